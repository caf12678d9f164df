model ArgumentShape "Calls a function of two elements with three"
  function total "Sum of two"
    input Real v[2] "Elements";
    output Real y "Sum";
  algorithm
    y := v[1] + v[2];
  end total;
  Real x(unit="1", start=1, fixed=true) "State";
equation
  der(x) = -total({x, x, x});
end ArgumentShape;

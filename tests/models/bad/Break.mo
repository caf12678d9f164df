model Break "Leaves a loop early"
  function summed "Sum up to the first negative element"
    input Real v[3] "Elements";
    output Real y "Sum";
  algorithm
    y := 0;
    for i in 1:3 loop
      if v[i] < 0 then
        break;
      end if;
      y := y + v[i];
    end for;
  end summed;
  Real x(unit="1", start=1, fixed=true) "State";
equation
  der(x) = -summed({x, 2*x, 3*x});
end Break;

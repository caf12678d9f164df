model Algorithm "A while-loop whose turns depend on a variable"
  Real x(unit="1", start=1, fixed=true) "State";
  Real y(unit="1") "Next whole number";
algorithm
  y := 0;
  while y < x loop
    y := y + 1;
  end while;
equation
  der(x) = y;
end Algorithm;

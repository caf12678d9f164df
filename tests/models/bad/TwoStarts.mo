model TwoStarts "Two different starts of what is one variable"
  Real x(unit="1", start=1, fixed=true) "State";
  Real y(unit="1", start=2, fixed=true) "The same";
equation
  der(x) = -x;
  y = x;
end TwoStarts;

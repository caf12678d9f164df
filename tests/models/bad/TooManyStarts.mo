model TooManyStarts "Three fixed starts for one degree of freedom"
  Real x(unit="1", start=1, fixed=true) "State";
  Real y(unit="1", start=2, fixed=true) "Twice the state";
  Real z(unit="1", start=5, fixed=true) "Its square";
equation
  der(x) = -x;
  y = 2*x;
  z = x^2;
end TooManyStarts;

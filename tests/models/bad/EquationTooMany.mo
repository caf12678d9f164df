model EquationTooMany "One unknown, two equations"
  Real x(unit="1", start=1, fixed=true) "State";
equation
  der(x) = -x;
  x = 2;
end EquationTooMany;

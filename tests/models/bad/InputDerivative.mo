model InputDerivative "An input prescribes a position, so its derivatives would be needed"
  input Real x(unit="m") "Position";
  Real v(unit="m/s") "Speed";
  Real f(unit="N") "Force";
  output Real y(unit="m") "Position";
equation
  y = x;
  v = der(y);
  f = 2*v;
end InputDerivative;

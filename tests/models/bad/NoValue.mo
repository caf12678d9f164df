model NoValue "A parameter without value"
  parameter Real k(unit="1/s") "Rate";
  Real x(unit="1", start=1, fixed=true) "State";
equation
  der(x) = -k*x;
end NoValue;

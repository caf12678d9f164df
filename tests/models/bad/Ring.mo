model Ring "Parameters that depend on each other"
  parameter Real a(unit="1") = 2*b "First";
  parameter Real b(unit="1") = a + c "Second";
  parameter Real c(unit="1") = 1 "Third";
  Real x(unit="1", start=1, fixed=true) "State";
equation
  der(x) = -a*x;
end Ring;

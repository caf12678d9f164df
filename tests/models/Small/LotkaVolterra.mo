within Small;
model LotkaVolterra "Prey and predators"
  output Real x(unit="1", start=2, fixed=true) "Prey";
  output Real y(unit="1", start=1, fixed=true) "Predators";
  output Real H(unit="1/s") "What stays constant";
  parameter Real a(unit="1/s") = 1.1 "Growth of the prey";
  parameter Real b(unit="1/s") = 0.4 "Prey eaten by one predator";
  parameter Real c(unit="1/s") = 0.4 "Death of the predators";
  parameter Real d(unit="1/s") = 0.1 "Growth of the predators for each prey";
equation
  der(x) = a*x - b*x*y;
  der(y) = d*x*y - c*y;
  H = d*x - c*log(x) + b*y - a*log(y);
end LotkaVolterra;

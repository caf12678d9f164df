model DerivativeOfExpression "Conservation of momentum of a cart that loses mass"
  output Real m(unit="kg", start=10, fixed=true) "Mass";
  output Real v(unit="m/s", start=2, fixed=true) "Speed";
  output Real p(unit="kg.m/s") "Momentum";
  parameter Real q(unit="kg/s") = 0.5 "Loss of mass";
  parameter Real F(unit="N") = 3 "Force";
equation
  der(m) = -q;
  // the sand leaves at rest
  der(m*v) = F;
  p = m*v;
end DerivativeOfExpression;

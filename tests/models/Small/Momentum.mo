within Small;
model Momentum "Momentum of a cart that loses mass"
  output Parts.Mass m(start=10, fixed=true) "Mass";
  output Parts.Velocity v(start=2, fixed=true) "Speed";
  output Real p(unit="kg.m/s") "Momentum";
  parameter Real q(unit="kg/s") = 0.5 "Loss of mass";
  parameter Real F(unit="N") = 3 "Force";
equation
  der(m) = -q;
  // the sand leaves at rest
  p = m*v;
  der(p) = F;
end Momentum;

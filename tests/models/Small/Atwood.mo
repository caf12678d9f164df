within Small;
model Atwood "Two masses on a rope over a pulley with inertia"
  parameter Parts.Mass m_1 = 3 "First mass";
  parameter Parts.Mass m_2 = 2 "Second mass";
  parameter Parts.MomentOfInertia J = 0.01 "Inertia of the pulley";
  parameter Parts.Length r = 0.1 "Radius of the pulley";
  constant Parts.Acceleration g = 9.81 "Gravity";
  output Parts.Length x_1(start=0, fixed=true) "Depth of the first mass";
  output Parts.Length x_2 "Depth of the second mass";
  output Parts.Velocity v_1(start=0, fixed=true) "Speed of the first mass, downwards";
  output Parts.Force F_1 "Rope's force on the first mass";
  output Parts.Force F_2 "Rope's force on the second mass";
  Parts.Velocity v_2 "Speed of the second mass, downwards";
  Parts.Angle phi "Angle of the pulley";
  Parts.AngularVelocity w "Speed of the pulley";
equation
  // the rope has one length and does not slip
  x_1 + x_2 = 1;
  x_1 = r*phi;
  v_1 = der(x_1);
  v_2 = der(x_2);
  w = der(phi);
  m_1*der(v_1) = m_1*g - F_1;
  m_2*der(v_2) = m_2*g - F_2;
  J*der(w) = r*(F_1 - F_2);
end Atwood;

within Small;
model RollingWheel "A wheel rolls down a slope without slip"
  parameter Parts.Mass m = 2 "Mass";
  parameter Parts.Length r = 0.3 "Radius";
  parameter Real shape(unit="1") = 0.5 "Moment of inertia over m*r^2: a disc";
  parameter Parts.MomentOfInertia J = shape*m*r^2 "Moment of inertia";
  parameter Parts.Angle slope = 0.2 "Slope";
  constant Parts.Acceleration g = 9.81 "Gravity";
  output Parts.Length x(start=0, fixed=true) "Way along the slope";
  output Parts.Velocity v(start=0, fixed=true) "Speed";
  output Parts.Angle phi "Angle of the wheel";
  output Parts.Force F "Friction that makes it roll";
  Parts.AngularVelocity w "Speed of rotation";
equation
  // no slip
  x = r*phi;
  v = der(x);
  w = der(phi);
  m*der(v) = m*g*sin(slope) - F;
  J*der(w) = r*F;
end RollingWheel;

within Small;
model PendulumAngle "The same pendulum in its angle"
  constant Parts.Acceleration g = 9.81 "Gravity";
  parameter Parts.Length L = 0.7 "Length of the rod";
  output Parts.Angle phi(start=0.5, fixed=true) "Angle from the vertical";
  output Parts.AngularVelocity w(start=0, fixed=true) "Speed";
equation
  w = der(phi);
  L*der(w) = -g*sin(phi);
end PendulumAngle;

within Small;
model PendulumXY "Pendulum in Cartesian coordinates: index 3"
  constant Parts.Acceleration g = 9.81 "Gravity";
  parameter Parts.Length L = 0.7 "Length of the rod";
  parameter Parts.Mass m = 1.3 "Mass";
  output Parts.Length x(start=0.7*sin(0.5)) "Horizontal position";
  output Parts.Length y(start=-0.7*cos(0.5)) "Vertical position, upwards";
  output Parts.Velocity vx "Horizontal speed";
  output Parts.Velocity vy "Vertical speed";
  output Parts.Energy E "Energy";
  Real F(unit="N") "Tension of the rod";
initial equation
  x = L*sin(0.5);
  vx = 0;
equation
  vx = der(x);
  vy = der(y);
  m*der(vx) = -F*x/L;
  m*der(vy) = -F*y/L - m*g;
  x^2 + y^2 = L^2;
  E = m*(vx^2 + vy^2)/2 + m*g*y;
end PendulumXY;

within Small;
model Cycloid "A bead slides on a wire bent to a cycloid, in Cartesian coordinates"
  parameter Parts.Length r = 0.5 "Radius of the circle that rolls the cycloid";
  parameter Parts.Mass m = 0.3 "Mass";
  constant Parts.Acceleration g = 9.81 "Gravity";
  parameter Parts.Angle start = 1 "Where the bead is released";
  output Parts.Angle theta(stateSelect=StateSelect.always) "Angle of the circle; the bottom is at pi";
  output Parts.Length x "Horizontal position";
  output Parts.Length y "Height";
  output Parts.Energy E "Energy";
  Parts.AngularVelocity w(stateSelect=StateSelect.always) "Rate of the angle";
  Parts.Velocity v_x "Horizontal speed";
  Parts.Velocity v_y "Vertical speed";
  Parts.Force N "Force of the wire, across its tangent, for a unit of 2*sin(theta/2)";
initial equation
  theta = start;
  w = 0;
equation
  x = r*(theta - sin(theta));
  y = r*(cos(theta) - 1);
  w = der(theta);
  v_x = der(x);
  v_y = der(y);
  // the tangent is (1 - cos(theta), -sin(theta)); the wire pushes across it
  m*der(v_x) = N*sin(theta);
  m*der(v_y) = N*(1 - cos(theta)) - m*g;
  E = m*(v_x^2 + v_y^2)/2 + m*g*y;
end Cycloid;

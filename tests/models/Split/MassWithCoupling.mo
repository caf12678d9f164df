within Split;
model MassWithCoupling "The second mass, and the spring and damper of the coupling: motion in, force out at once"
  input Types.Length x1(start=0) "Place of the first mass";
  input Types.Velocity v1(start=0) "Velocity of the first mass";
  output Types.Force F "Force of the coupling on the first mass";
  output Types.Length x(start=0, fixed=true) "Place";
  output Types.Velocity v(start=0, fixed=true) "Velocity";
  parameter Types.Mass m = 2 "Mass";
  parameter Types.Stiffness c = 10 "Spring to the wall";
  parameter Types.Damping d = 0.2 "Damper to the wall";
  parameter Types.Stiffness c_coupling = 5 "Spring of the coupling";
  parameter Types.Damping d_coupling = 0.3 "Damper of the coupling";
equation
  F = c_coupling*(x - x1) + d_coupling*(v - v1);
  der(x) = v;
  // balance of forces; action is reaction
  m*der(v) = -F - c*x - d*v;
end MassWithCoupling;

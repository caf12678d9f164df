within Split;
model MassOnSpring "The first mass, on a spring and a damper; the coupling is a force"
  input Types.Force F(start=0) "Force of the coupling, positive in the direction of x";
  output Types.Length x(start=1, fixed=true) "Place";
  output Types.Velocity v(start=0, fixed=true) "Velocity";
  parameter Types.Mass m = 1 "Mass";
  parameter Types.Stiffness c = 10 "Spring to the wall";
  parameter Types.Damping d = 0.2 "Damper to the wall";
equation
  der(x) = v;
  // balance of forces
  m*der(v) = F - c*x - d*v;
end MassOnSpring;

within Split;
model MassBesideOther "One of two masses with a coupling of its own: motion in, motion out, nothing at once"
  input Types.Length x_other(start=0) "Place of the other mass";
  input Types.Velocity v_other(start=0) "Velocity of the other mass";
  output Types.Length x(start=x0, fixed=true) "Place";
  output Types.Velocity v(start=0, fixed=true) "Velocity";
  parameter Types.Length x0 = 0 "Place at the start";
  parameter Types.Mass m = 1 "Mass";
  parameter Types.Stiffness c = 10 "Spring to the wall";
  parameter Types.Damping d = 0.2 "Damper to the wall";
  parameter Types.Stiffness c_coupling = 5 "Spring of the coupling";
  parameter Types.Damping d_coupling = 0.3 "Damper of the coupling";
equation
  der(x) = v;
  // balance of forces
  m*der(v) = c_coupling*(x_other - x) + d_coupling*(v_other - v) - c*x - d*v;
end MassBesideOther;

within Small;
model Cyclotron "A charged particle in crossed electric and magnetic fields"
  output Parts.Length x(start=0, fixed=true) "Place along the electric field";
  output Parts.Length y(start=0, fixed=true) "Place across it";
  Parts.Velocity v_x(start=1, fixed=true) "Speed";
  Parts.Velocity v_y(start=0, fixed=true) "Speed";
  parameter Real w(unit="rad/s") = 4 "Cyclotron frequency";
  parameter Parts.Velocity drift = 0.5 "Electric over magnetic field";
equation
  der(x) = v_x;
  der(y) = v_y;
  der(v_x) = w*(v_y + drift);
  der(v_y) = -w*v_x;
end Cyclotron;

within Small;
model StickSlip "A mass on a moving belt, held by a spring, sticks and slips in turn"
  parameter Parts.Mass m = 1 "Mass";
  parameter Real k(unit="N/m") = 50 "Stiffness of the spring";
  parameter Parts.Velocity v_belt = 0.1 "Speed of the belt";
  parameter Parts.Force F_s = 8 "Largest force of static friction";
  parameter Parts.Force F_k = 5 "Kinetic friction";
  output Parts.Length x(start=0, fixed=true) "Place of the mass: extension of the spring";
  output Parts.Velocity v(start=0.1, fixed=true) "Speed of the mass";
  output Boolean sticking(start=true, fixed=true) "True while the mass moves with the belt";
  output Integer slips(start=0, fixed=true) "How often it has broken loose";
  Parts.Force F "Friction on the mass, in the belt's direction";
equation
  der(x) = v;
  // balance of forces; the belt is never overtaken
  m*der(v) = F - k*x;
  F = if sticking then k*x else F_k;
  when sticking then
    reinit(v, v_belt);
  end when;
algorithm
  when k*x > F_s then
    sticking := false;
    slips := pre(slips) + 1;
  elsewhen v > v_belt then
    sticking := true;
  end when;
end StickSlip;

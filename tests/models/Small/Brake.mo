within Small;
model Brake "Dry friction with a stuck mode: it holds the rotor until the torque exceeds it"
  input Parts.Torque tau(start=0) "Torque from outside";
  output Parts.Angle phi(start=0, fixed=true) "Angle";
  output Parts.AngularVelocity w(start=10, fixed=true) "Speed";
  output Boolean stuck(start=false, fixed=true) "True while friction holds the rotor";
  output Parts.Torque tau_f "Torque of the friction, against the motion";
  parameter Parts.MomentOfInertia J = 0.5 "Moment of inertia";
  parameter Parts.Torque tau_0 = 2 "Largest torque of the friction";
  Integer direction(start=1, fixed=true) "Sense of rotation, or in which it was last";
equation
  w = der(phi);
  // balance of moments
  J*der(w) = tau - tau_f;
  tau_f = if stuck then tau else direction*tau_0;
  when stuck then
    reinit(w, 0);
  end when;
algorithm
  when pre(direction) > 0 and w < 0 or pre(direction) < 0 and w > 0 then
    stuck := abs(tau) <= tau_0;
    direction := if pre(stuck) then pre(direction) elseif stuck then pre(direction) else -pre(direction);
  elsewhen pre(stuck) and tau > tau_0 then
    stuck := false;
    direction := 1;
  elsewhen pre(stuck) and tau < -tau_0 then
    stuck := false;
    direction := -1;
  end when;
end Brake;

within Small;
model Backlash "Two rotors joined by an elastic shaft with backlash"
  parameter Parts.MomentOfInertia J = 0.2 "Inertia of each rotor";
  parameter Real c(unit="N.m/rad") = 400 "Stiffness in contact";
  parameter Parts.Angle b = 0.1 "Play to each side";
  output Parts.Angle phi_1(start=0, fixed=true) "Angle of the first rotor";
  output Parts.Angle phi_2(start=0, fixed=true) "Angle of the second rotor";
  output Parts.AngularVelocity w_1(start=1, fixed=true) "Speed of the first rotor";
  output Parts.AngularVelocity w_2(start=0, fixed=true) "Speed of the second rotor";
  output Boolean contact "True while the flanks touch";
  Parts.Angle twist "Angle of the first against the second";
  Parts.Torque tau "Torque on the second rotor";
equation
  twist = phi_1 - phi_2;
  contact = twist > b or twist < -b;
  tau = if twist > b then c*(twist - b) elseif twist < -b then c*(twist + b) else 0;
  w_1 = der(phi_1);
  w_2 = der(phi_2);
  J*der(w_1) = -tau;
  J*der(w_2) = tau;
end Backlash;

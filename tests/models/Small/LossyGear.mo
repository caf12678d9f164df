within Small;
model LossyGear "A gear that loses a part of the power that passes it, whichever way that goes"
  input Parts.Torque tau(start=3) "Torque on the fast shaft";
  output Parts.AngularVelocity w_1 "Speed of the fast shaft";
  output Parts.AngularVelocity w_2(start=1, fixed=true) "Speed of the slow shaft";
  output Parts.Energy E_lost(start=0, fixed=true) "Energy lost so far";
  output Boolean driving "True while power goes from the fast shaft to the slow one";
  parameter Real ratio(unit="1") = 4 "Ratio";
  parameter Real eta(unit="1") = 0.7 "Efficiency";
  parameter Parts.MomentOfInertia J_1 = 0.02 "Inertia of the fast shaft";
  parameter Parts.MomentOfInertia J_2 = 1.5 "Inertia of the slow shaft";
  Parts.Torque tau_1 "Torque into the gear at the fast shaft";
  Parts.Torque tau_2 "Torque out of the gear at the slow shaft";
equation
  w_1 = ratio*w_2;
  J_1*der(w_1) = tau - tau_1;
  J_2*der(w_2) = tau_2;
  driving = tau_1*w_1 > 0;
  tau_2 = ratio*tau_1*(if driving then eta else 1/eta);
  der(E_lost) = tau_1*w_1 - tau_2*w_2;
end LossyGear;

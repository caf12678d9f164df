within WiperDrive.Rotational;
model WormGear "Worm gear whose efficiency depends on the direction of the power flow"
  parameter Types.Ratio ratio = 73 "Turns of the worm per turn of the gear [S] table 3.3";
  parameter Types.Ratio eta_wg = 0.74 "Efficiency while power flows from the worm to the gear [S] table 3.3";
  parameter Types.Ratio eta_gw = 0.65 "Efficiency while power flows from the gear to the worm [S] table 3.3";
  parameter Types.Power P_th = 0.001 "Power above which the efficiencies hold in full [S] table 3.3";
  parameter Types.Ratio sharpness = 4 "Argument of tanh at P_th [A] Simscape's documented smoothing: tanh(4) = 0.9993";
  Interfaces.Flange flange_a "Worm";
  Interfaces.Flange flange_b "Gear";
  Types.Torque tau_worm "Torque that the worm receives";
  Types.Torque tau_gear "Torque that the gear delivers";
  Types.AngularVelocity w_worm "Speed of the worm";
  Types.AngularVelocity w_gear "Speed of the gear";
  Types.Power P "Power from the worm to the gear, measured at the worm";
  Types.Power P_loss "Power turned into heat";
equation
  flange_a.phi = ratio*flange_b.phi;
  w_worm = der(flange_a.phi);
  w_gear = der(flange_b.phi);
  tau_worm = flange_a.tau;
  tau_gear = -flange_b.tau;
  P = tau_worm*w_worm;
  // Balance of torques: tau_gear = ratio*eta_wg*tau_worm while the worm drives, tau_worm = eta_gw*tau_gear/ratio while
  // the gear drives. Around zero power the efficiency goes to 1 smoothly. Value and slope of the two branches agree at
  // P = 0, so the switch needs no event, and one would chatter while the drive stands still.
  tau_gear = ratio*tau_worm*noEvent(
    if P > 0 then 1 - (1 - eta_wg)*tanh(sharpness*P/P_th)
    else 1 + (1/eta_gw - 1)*tanh(-sharpness*P/P_th));
  P_loss = tau_worm*w_worm - tau_gear*w_gear;
end WormGear;

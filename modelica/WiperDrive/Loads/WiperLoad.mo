within WiperDrive.Loads;
model WiperLoad "Load of the wiper blade on its rocker: equation 3.1, or the naive estimate before it"
  parameter Types.Torque ext_load = 3 "External load [S] table 3.2";
  parameter Types.Ratio depth = 0.7 "Share of the load that depends on the crank angle [S] equation 3.1";
  parameter Types.AngularVelocity w_s = 1e-3
    "Speed over which the sign of the speed is smoothed [A] small; at rest the wiper creeps under this speed";
  parameter Boolean naive = false "True: the naive estimate [S] figure 3.4, which figures 3.5 and 3.6 show";
  parameter Types.Torque T_slip = 1 "Friction of the naive estimate while slipping [A] the source gives none";
  parameter Types.Torque T_stick = 2 "Friction of the naive estimate near standstill [A] the source gives none";
  parameter Types.AngularVelocity w_stick = 0.05 "Speed below which the blade sticks, naive estimate [A] the source gives none";
  input Types.Angle phi_crank "Crank angle";
  Interfaces.Flange flange "Rocker shaft";
  Types.AngularVelocity w "Speed of the rocker";
  Types.Torque size "Load at full speed in the direction of the motion";
  Types.Torque tau "Load, with the sign of the speed";
  Types.Power P "Power taken from the rocker";
equation
  w = der(flange.phi);
  // Simple: equation 3.1. Naive: the external load times the cosine of the crank angle, with Karnopp's friction, whose
  // shape the source leaves open; here it falls from T_stick to T_slip with the speed.
  size = if naive then ext_load*cos(phi_crank) + T_slip + (T_stick - T_slip)/(1 + (w/w_stick)^2)
    else (1 - abs(depth*cos(phi_crank)))*ext_load;
  // sgn(w) = tanh(w/w_s): the load opposes the motion
  tau = size*tanh(w/w_s);
  flange.tau = tau;
  P = tau*w;
end WiperLoad;

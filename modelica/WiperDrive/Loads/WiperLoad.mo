within WiperDrive.Loads;
model WiperLoad "Load of the wiper blade on its rocker, equation 3.1"
  parameter Types.Torque ext_load = 3 "External load [S] table 3.2";
  parameter Types.Ratio depth = 0.7 "Share of the load that depends on the crank angle [S] equation 3.1";
  parameter Types.AngularVelocity w_s = 1e-3
    "Speed over which the sign of the speed is smoothed [A] small; at rest the wiper creeps under this speed";
  input Types.Angle phi_crank "Crank angle";
  Interfaces.Flange flange "Rocker shaft";
  Types.AngularVelocity w "Speed of the rocker";
  Types.Torque tau "Load, with the sign of the speed";
  Types.Power P "Power taken from the rocker";
equation
  w = der(flange.phi);
  // equation 3.1, with sgn(w) = tanh(w/w_s): the load opposes the motion
  tau = (1 - abs(depth*cos(phi_crank)))*tanh(w/w_s)*ext_load;
  flange.tau = tau;
  P = tau*w;
end WiperLoad;

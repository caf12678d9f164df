within WiperDrive.Rotational;
model TorqueSource "Torque of the surroundings on a shaft"
  input Types.Torque tau "Torque on the shaft, positive in the direction of rotation";
  Interfaces.Flange flange "Shaft";
  Types.Power P "Power given to the shaft";
equation
  flange.tau = -tau;
  P = tau*der(flange.phi);
end TorqueSource;

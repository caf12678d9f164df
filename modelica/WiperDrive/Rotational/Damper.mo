within WiperDrive.Rotational;
model Damper "Viscous damping against the housing"
  parameter Types.RotationalDamping d = 1 "Damping [A] set by the model that uses it";
  Interfaces.Flange flange "Shaft";
  Types.AngularVelocity w "Speed";
  Types.Power P_loss "Power turned into heat";
equation
  w = der(flange.phi);
  // viscous friction
  flange.tau = d*w;
  P_loss = d*w^2;
end Damper;

within WiperDrive.Electrical;
model EMF "Ideal electromechanical converter"
  extends Interfaces.TwoPin;
  parameter Types.MotorConstant k = 1 "Torque per current and back-EMF per speed [A] set by the model that uses it";
  Interfaces.Flange flange "Rotor";
  Types.AngularVelocity w "Speed of the rotor";
equation
  w = der(flange.phi);
  // induced voltage, and the torque for which the conversion has no loss
  v = k*w;
  flange.tau = -k*i;
end EMF;

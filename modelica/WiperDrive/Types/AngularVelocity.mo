within WiperDrive.Types;
type AngularVelocity = Real(unit="rad/s") "Angular velocity";

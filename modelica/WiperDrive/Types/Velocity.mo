within WiperDrive.Types;
type Velocity = Real(unit="m/s") "Velocity";

within WiperDrive.Types;
type Acceleration = Real(unit="m/s2") "Acceleration";

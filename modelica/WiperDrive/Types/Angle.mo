within WiperDrive.Types;
type Angle = Real(unit="rad") "Angle";

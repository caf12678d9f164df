within WiperDrive.Types;
type Inductance = Real(unit="H", min=0) "Inductance";

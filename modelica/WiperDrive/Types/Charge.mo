within WiperDrive.Types;
type Charge = Real(unit="C") "Electric charge";

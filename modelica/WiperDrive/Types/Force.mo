within WiperDrive.Types;
type Force = Real(unit="N") "Force";

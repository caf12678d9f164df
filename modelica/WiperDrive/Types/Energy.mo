within WiperDrive.Types;
type Energy = Real(unit="J") "Energy";

within WiperDrive.Types;
type Power = Real(unit="W") "Power";

within WiperDrive.Types;
type Length = Real(unit="m") "Length";

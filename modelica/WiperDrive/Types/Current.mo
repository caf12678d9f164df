within WiperDrive.Types;
type Current = Real(unit="A") "Electric current";

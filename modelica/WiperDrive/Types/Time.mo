within WiperDrive.Types;
type Time = Real(unit="s") "Time";

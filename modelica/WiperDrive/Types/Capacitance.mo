within WiperDrive.Types;
type Capacitance = Real(unit="F") "Capacitance";

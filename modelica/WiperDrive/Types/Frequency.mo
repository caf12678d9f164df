within WiperDrive.Types;
type Frequency = Real(unit="Hz") "Frequency";

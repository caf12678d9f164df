within WiperDrive.Types;
type Voltage = Real(unit="V") "Voltage";

within WiperDrive.Types;
type Ratio = Real(unit="1") "Dimensionless number";

within WiperDrive.Types;
type Density = Real(unit="kg/m3", min=0) "Density";

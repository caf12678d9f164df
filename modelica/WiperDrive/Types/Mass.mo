within WiperDrive.Types;
type Mass = Real(unit="kg", min=0) "Mass";

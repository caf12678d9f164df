within WiperDrive.Types;
type Resistance = Real(unit="Ohm", min=0) "Resistance";

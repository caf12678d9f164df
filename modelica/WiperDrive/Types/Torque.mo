within WiperDrive.Types;
type Torque = Real(unit="N.m") "Torque";

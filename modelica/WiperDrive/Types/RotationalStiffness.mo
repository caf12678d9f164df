within WiperDrive.Types;
type RotationalStiffness = Real(unit="N.m/rad", min=0) "Stiffness of a rotation";

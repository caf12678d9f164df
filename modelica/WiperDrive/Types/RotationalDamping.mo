within WiperDrive.Types;
type RotationalDamping = Real(unit="N.m.s/rad", min=0) "Viscous damping of a rotation";

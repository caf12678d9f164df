within WiperDrive.Types;
type MomentOfInertia = Real(unit="kg.m2", min=0) "Moment of inertia";

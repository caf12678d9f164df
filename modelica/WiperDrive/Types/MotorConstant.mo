within WiperDrive.Types;
type MotorConstant = Real(unit="N.m/A", min=0) "Torque per current = back-EMF per speed";

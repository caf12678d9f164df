within WiperDrive.Systems;
model RigPlant "Lifetime-test rig of chapter 4: the motor and its gear turn a weight on an arm"
  extends Drive;
  parameter Types.Mass m_arm = 2.35 "Mass on the arm [S] chapter 4";
  parameter Types.Length l_arm = 0.25 "Distance from the shaft to the mass [S] chapter 4";
  output Types.Angle phi_arm "Angle of the arm, 270 deg at the start: hanging";
  Loads.GravityArm arm(m=m_arm, l=l_arm) "Arm with its weight";
  Types.Energy E_kinetic "Kinetic energy";
  Types.Energy E_potential "Potential energy";
equation
  connect(gear.flange_b, arm.flange);
  phi_arm = arm.phi_arm;
  E_kinetic = motor.rotor.E_kinetic + arm.E_kinetic;
  E_potential = arm.E_potential;
end RigPlant;

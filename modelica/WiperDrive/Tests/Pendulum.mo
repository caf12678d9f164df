within WiperDrive.Tests;
model Pendulum "The rig's arm swings freely from 0.1 rad: its energy is conserved"
  Loads.GravityArm arm(flange(phi(start=0.1, fixed=true)), w(start=0, fixed=true)) "Arm without motor";
  Types.Energy E "Total energy";
equation
  E = arm.E_kinetic + arm.E_potential;
end Pendulum;

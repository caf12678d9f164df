within WiperDrive.Tests;
model GearBackDriven "A torque on the gear turns a damper on the worm: 65 % of the power arrives"
  Rotational.TorqueSource worm_torque(tau=0) "Torque on the worm";
  Rotational.Inertia worm(J=1e-4) "Inertia of the worm";
  Rotational.Damper worm_damper(d=1e-3) "Damper on the worm";
  Rotational.WormGear gear "Gear";
  Rotational.Inertia wheel(J=0.01, phi(start=0, fixed=true), w(start=0, fixed=true)) "Inertia of the gear";
  Rotational.Damper wheel_damper(d=1e-9) "Damper on the gear";
  Rotational.TorqueSource wheel_torque(tau=10) "Torque on the gear";
equation
  connect(worm_torque.flange, worm.flange_a);
  connect(worm.flange_a, worm_damper.flange);
  connect(worm.flange_b, gear.flange_a);
  connect(gear.flange_b, wheel.flange_a);
  connect(wheel.flange_b, wheel_damper.flange);
  connect(wheel.flange_b, wheel_torque.flange);
end GearBackDriven;

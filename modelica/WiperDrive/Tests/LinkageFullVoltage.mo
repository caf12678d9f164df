within WiperDrive.Tests;
model LinkageFullVoltage "The linkage plant at full voltage, without controller"
  Systems.LinkagePlant plant "Plant";
equation
  plant.duty = 1;
  plant.v_supply = 28;
  plant.tau_disturbance = 0;
end LinkageFullVoltage;

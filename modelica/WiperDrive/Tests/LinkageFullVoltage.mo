within WiperDrive.Tests;
model LinkageFullVoltage "The linkage plant at full voltage, without controller"
  Systems.LinkagePlant plant(duty=1, v_supply=28, tau_disturbance=0) "Plant";
end LinkageFullVoltage;

within WiperDrive.Tests;
model ProfileTrajectory "The voltage profile with the half revolution of figure 3.12, 1 s, and a current that invites every turn"
  Controllers.VoltageProfile controller(stop_ratio=1, i_motor=0.5, park=time < 0.05, enable=true)
    "Controller, with the soft stop as figure 3.12 draws it";
end ProfileTrajectory;

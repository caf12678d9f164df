within WiperDrive.Tests;
model RigCharge "The rig at the averaged and at the switched bridge, with the charge that goes through the motor"
  parameter Types.Ratio duty = 0.7 "Duty ratio [A] any";
  parameter Types.Frequency f_pwm = 1e5 "Frequency of the pulses [S] 4.4.1: 100 kHz";
  Systems.RigPlant averaged(duty=duty, v_supply=28, tau_disturbance=0) "Rig with the averaged bridge";
  Systems.SwitchedRigPlant switched(duty=duty, v_supply=28, tau_disturbance=0, bridge(f_pwm=f_pwm))
    "Rig with the switched bridge";
  Types.Charge q_a(start=0, fixed=true) "Charge through the first motor";
  Types.Charge q_s(start=0, fixed=true) "Charge through the second motor";
equation
  der(q_a) = averaged.bridge.i;
  der(q_s) = switched.bridge.i;
end RigCharge;

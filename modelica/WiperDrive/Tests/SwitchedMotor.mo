within WiperDrive.Tests;
model SwitchedMotor "Two equal motors that turn steadily, one at the averaged bridge, one at the switched one"
  parameter Types.Ratio duty = 0.5 "Duty ratio [A] any";
  parameter Types.Voltage V = 28 "Supply voltage [S] 4.2.1";
  parameter Types.Frequency f_pwm = 1000 "Frequency of the pulses [S] figure 4.8";
  parameter Types.AngularVelocity w = 100 "Speed of both rotors [A] any";
  Electrical.HBridge averaged(duty=duty, v_supply=V) "Averaged bridge";
  Electrical.SwitchedBridge switched(duty=duty, v_supply=V, f_pwm=f_pwm) "Switched bridge";
  Electrical.Ground ground "Chassis";
  Electrical.Motor motor_a "Motor at the averaged bridge";
  Electrical.Motor motor_s "Motor at the switched bridge";
  Rotational.ConstantSpeed drive_a(w=w) "Turns the first rotor";
  Rotational.ConstantSpeed drive_s(w=w) "Turns the second rotor";
  Types.Charge q_a(start=0, fixed=true) "Charge that has gone through the first motor";
  Types.Charge q_s(start=0, fixed=true) "Charge that has gone through the second motor";
equation
  connect(averaged.p, motor_a.p);
  connect(averaged.n, motor_a.n);
  connect(averaged.n, ground.p);
  connect(motor_a.flange, drive_a.flange);
  connect(switched.p, motor_s.p);
  connect(switched.n, motor_s.n);
  connect(switched.n, ground.p);
  connect(motor_s.flange, drive_s.flange);
  der(q_a) = averaged.i;
  der(q_s) = switched.i;
end SwitchedMotor;

within WiperDrive.Systems;
partial model Drive "Bridge, motor, worm gear and park sensor: what the plants have in common"
  parameter Types.MomentOfInertia J_rotor = 1.0e-4 "Rotor inertia [A] usual for a 70 W wiper motor for 24 V";
  parameter Types.MotorConstant k_emf = 0.113 "Torque and back-EMF constant of the motor [S] table 3.4";
  parameter Types.Angle park_width = 2*Constants.pi/180
    "Angle over which the park contact is closed [S] 3.2.1: about 2 deg";
  parameter Types.Current i_max = 1000
    "Current to which the bridge limits itself [A] off; [S] 4.2: supply 10 A, bridge 15 A";
  parameter Boolean short_brake = false
    "True: at duty ratio zero the motor is shorted to brake [A] off; the production motor does so when it parks";
  input Types.Ratio duty(start=0, min=0, max=1) "Duty ratio of the H-bridge, 0..1";
  input Types.Voltage v_supply(start=28) "Supply voltage";
  input Types.Torque tau_disturbance(start=0)
    "Torque of the surroundings on the gear's output shaft, positive in the direction of rotation";
  output Types.Current i_motor "Motor current, never negative";
  output Types.Voltage v_motor "Voltage at the motor's terminals";
  output Boolean park "True on the park contact";
  output Types.Angle phi_crank(start=0, fixed=true, stateSelect=StateSelect.always)
    "Angle of the gear's output shaft, zero at the start, not wrapped";
  output Types.AngularVelocity w_crank(start=0, fixed=true, stateSelect=StateSelect.always)
    "Speed of the gear's output shaft";
  output Types.AngularVelocity w_motor "Speed of the rotor";
  output Types.Torque tau_crank "Torque that the gear delivers to its output shaft";
  replaceable model BridgeModel = Electrical.HBridge constrainedby Electrical.Bridge "Kind of bridge: averaged or switched";
  BridgeModel bridge(i_max=i_max, short_brake=short_brake, duty=duty, v_supply=v_supply) "Bridge";
  Electrical.Ground ground "Chassis";
  Electrical.Motor motor(J=J_rotor, k=k_emf) "Motor";
  Rotational.WormGear gear "Worm gear";
  Rotational.TorqueSource disturbance(tau=tau_disturbance) "Torque of the surroundings";
  Rotational.ParkSensor sensor(width=park_width) "Park contact";
  Types.Power P_supply "Power taken from the supply";
  Types.Power P_copper "Power turned into heat in the armature";
  Types.Power P_rotor "Power turned into heat by the rotor's friction";
  Types.Power P_gear "Power turned into heat in the gear";
  Types.Power P_disturbance "Power given to the output shaft by the surroundings";
  Types.Energy E_magnetic "Energy of the magnetic fields";
equation
  connect(bridge.p, motor.p);
  connect(bridge.n, motor.n);
  connect(bridge.n, ground.p);
  connect(motor.flange, gear.flange_a);
  connect(gear.flange_b, disturbance.flange);
  connect(gear.flange_b, sensor.flange);
  i_motor = bridge.i_switch;
  v_motor = bridge.v;
  park = sensor.on;
  phi_crank = gear.flange_b.phi;
  w_crank = der(phi_crank);
  w_motor = motor.rotor.w;
  tau_crank = gear.tau_gear;
  P_supply = bridge.P_supply;
  P_copper = motor.resistor.P_loss;
  P_rotor = motor.friction.P_loss;
  P_gear = gear.P_loss;
  P_disturbance = disturbance.P;
  E_magnetic = motor.E_magnetic;
end Drive;

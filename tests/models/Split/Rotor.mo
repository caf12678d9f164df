within Split;
model Rotor "The mechanical side of a motor: torque in, speed out"
  input Types.Torque tau(start=0) "Torque of the motor";
  output Types.AngularVelocity w(start=0, fixed=true) "Speed";
  parameter Types.MomentOfInertia J = 0.25 "Inertia of rotor and load";
  parameter Types.Friction d = 0.1 "Friction of bearings and load";
equation
  // balance of torques
  J*der(w) = tau - d*w;
end Rotor;

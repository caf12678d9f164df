within Split;
model Winding "The electrical side of a direct current motor: speed in, torque out"
  input Types.Voltage u(start=1) "Voltage at the terminals";
  input Types.AngularVelocity w(start=0) "Speed of the rotor";
  output Types.Current i(start=0, fixed=true) "Current";
  output Types.Torque tau "Torque on the rotor";
  parameter Types.Resistance R = 1 "Resistance";
  parameter Types.Inductance L = 0.5 "Inductance";
  parameter Types.EmfConstant k = 1 "Constant of the motor";
equation
  // Kirchhoff's voltage law, with the voltage that the rotor induces
  L*der(i) = u - R*i - k*w;
  tau = k*i;
end Winding;

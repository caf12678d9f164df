within Split;
model Motor "Both sides of the motor in one"
  input Types.Voltage u(start=1) "Voltage at the terminals";
  output Types.Current i "Current";
  output Types.Torque tau "Torque on the rotor";
  output Types.AngularVelocity w "Speed";
  Winding winding(u=u, w=w) "Electrical side";
  Rotor rotor(tau=tau) "Mechanical side";
equation
  i = winding.i;
  tau = winding.tau;
  w = rotor.w;
end Motor;

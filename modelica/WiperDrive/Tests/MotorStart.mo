within WiperDrive.Tests;
model MotorStart "The motor alone at full voltage against the closed form of its two linear equations"
  Electrical.HBridge bridge(duty=1, v_supply=V) "Bridge";
  Electrical.Ground ground "Chassis";
  Electrical.Motor motor(rotor(phi(start=0, fixed=true), w(start=0, fixed=true))) "Motor without gear";
  parameter Types.Voltage V = 28 "Supply voltage [S] 4.2.1";
  final parameter Types.Inductance L = motor.L + 2*motor.L_filter "Inductance of the circuit [S] table 3.4";
  final parameter Types.Current i_end = motor.d*w_end/motor.k "Current in the end [A] closed form";
  final parameter Types.AngularVelocity w_end = motor.k*V/(motor.R*motor.d + motor.k^2) "Speed in the end [A] closed form";
  final parameter Real p(unit="1/s") = (motor.R/L + motor.d/motor.J)/2 "Mean of the two poles [A] closed form";
  final parameter Real q(unit="1/s") = sqrt(p^2 - (motor.R*motor.d + motor.k^2)/(L*motor.J))
    "Half the distance of the two poles [A] closed form";
  Types.Current i "Current in closed form";
  Types.AngularVelocity w "Speed in closed form";
  Types.Current i_error "Simulated minus closed form";
  Types.AngularVelocity w_error "Simulated minus closed form";
equation
  connect(bridge.p, motor.p);
  connect(bridge.n, motor.n);
  connect(bridge.n, ground.p);
  // i(0) = 0 and L*der(i)(0) = V; w(0) = 0 and der(w)(0) = 0
  i = i_end + ((V/L - (p + q)*i_end)*exp((q - p)*time) - (V/L - (p - q)*i_end)*exp(-(p + q)*time))/(2*q);
  w = w_end*(1 - ((p + q)*exp((q - p)*time) - (p - q)*exp(-(p + q)*time))/(2*q));
  i_error = bridge.i - i;
  w_error = motor.rotor.w - w;
end MotorStart;

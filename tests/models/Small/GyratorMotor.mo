within Small;
model GyratorMotor "A DC motor as a gyrator between an electric circuit and a rotor under a load"
  input Parts.Voltage u(start=12) "Supply";
  output Parts.Current i(start=0, fixed=true) "Current";
  output Parts.AngularVelocity w(start=0, fixed=true) "Speed";
  output Parts.Energy E_in(start=0, fixed=true) "Energy from the supply";
  output Parts.Energy E_out "Energy lost and stored";
  parameter Parts.Resistance R = 1 "Resistance";
  parameter Parts.Inductance L = 0.05 "Inductance";
  parameter Real k(unit="V.s/rad") = 0.2 "Gyration";
  parameter Parts.MomentOfInertia J = 0.01 "Inertia";
  parameter Real d(unit="N.m.s/rad") = 0.01 "Load, proportional to the speed";
  Parts.Energy E_lost(start=0, fixed=true) "Energy lost";
equation
  L*der(i) = u - R*i - k*w;
  J*der(w) = k*i - d*w;
  der(E_in) = u*i;
  der(E_lost) = R*i^2 + d*w^2;
  E_out = E_lost + L*i^2/2 + J*w^2/2;
end GyratorMotor;

within Small;
model SliderCrank "A crank drives a slider: the slider's place follows from the loop, as on paper"
  parameter Parts.Length r = 0.2 "Crank";
  parameter Parts.Length l = 0.6 "Rod";
  parameter Parts.Mass m = 2 "Mass of the slider";
  parameter Parts.MomentOfInertia J = 0.05 "Inertia of the crank";
  input Parts.Torque tau(start=0) "Torque on the crank";
  output Parts.Angle phi(start=0.3, fixed=true, stateSelect=StateSelect.always) "Angle of the crank";
  output Parts.AngularVelocity w(start=8, fixed=true, stateSelect=StateSelect.always) "Speed of the crank";
  output Parts.Angle psi(start=-0.1) "Angle of the rod against the slider's line";
  output Parts.Length x(start=0.79) "Place of the slider";
  output Parts.Velocity v "Speed of the slider";
  output Parts.Energy E "Kinetic energy";
  Real F(unit="N") "Force of the rod along the slider's line, on the slider";
  Real G(unit="N") "Force of the rod across the slider's line, on the crank pin";
equation
  // closed loop
  r*cos(phi) + l*cos(psi) = x;
  r*sin(phi) + l*sin(psi) = 0;
  w = der(phi);
  v = der(x);
  m*der(v) = F;
  // balance of moments of the massless rod about the slider
  0 = F*l*sin(psi) + G*l*cos(psi);
  J*der(w) = tau + F*r*sin(phi) + G*r*cos(phi);
  E = J*w^2/2 + m*v^2/2;
end SliderCrank;

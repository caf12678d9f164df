within WiperDrive.Rotational;
model Inertia "Rigid rotating body"
  parameter Types.MomentOfInertia J = 1 "Moment of inertia [A] set by the model that uses it";
  Interfaces.Flange flange_a "One end";
  Interfaces.Flange flange_b "Other end";
  Types.Angle phi "Angle";
  Types.AngularVelocity w "Speed";
  Types.Energy E_kinetic "Kinetic energy";
equation
  phi = flange_a.phi;
  phi = flange_b.phi;
  w = der(phi);
  // balance of angular momentum
  J*der(w) = flange_a.tau + flange_b.tau;
  E_kinetic = J*w^2/2;
end Inertia;

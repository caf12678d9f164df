within WiperDrive.Electrical;
model Inductor "Linear inductor"
  extends Interfaces.TwoPin;
  parameter Types.Inductance L = 1 "Inductance [A] set by the model that uses it";
  Types.Energy E_magnetic "Energy of the magnetic field";
equation
  // Faraday's law of induction
  L*der(i) = v;
  E_magnetic = L*i^2/2;
end Inductor;

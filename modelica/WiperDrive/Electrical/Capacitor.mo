within WiperDrive.Electrical;
model Capacitor "Linear capacitor"
  extends Interfaces.TwoPin;
  parameter Types.Capacitance C = 1 "Capacitance [A] set by the model that uses it";
equation
  // the charge is C*v
  C*der(v) = i;
end Capacitor;

within WiperDrive.Electrical;
model Resistor "Ohmic resistor"
  extends Interfaces.TwoPin;
  parameter Types.Resistance R = 1 "Resistance [A] set by the model that uses it";
  Types.Power P_loss "Power turned into heat";
equation
  // Ohm's law
  v = R*i;
  P_loss = v*i;
end Resistor;

within Small;
model OperatingPoint "A diode in series with a resistor: the exponential has to be solved at the start"
  input Parts.Voltage u(start=12) "Supply";
  output Parts.Current i "Current";
  output Parts.Voltage v "Voltage of the diode";
  output Parts.Voltage v_C "Voltage of the capacitor";
  parameter Parts.Resistance R = 100 "Resistance";
  parameter Parts.Current i_s = 1e-12 "Saturation current";
  parameter Parts.Voltage v_t = 0.025 "Thermal voltage";
  parameter Parts.Capacitance C = 1e-6 "Capacitance across the diode";
initial equation
  der(v_C) = 0;
equation
  v = v_C;
  i = i_s*(exp(v/v_t) - 1);
  C*der(v_C) = (u - v)/R - i;
end OperatingPoint;

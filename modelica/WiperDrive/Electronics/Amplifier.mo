within WiperDrive.Electronics;
model Amplifier "Difference amplifier that takes no current, with an output between ground and its supply"
  parameter Types.Ratio A = 50 "Gain [A] set by the model that uses it";
  parameter Types.Ratio gain_error = 0 "Relative error of the gain [A] the source gives none";
  parameter Types.Voltage v_offset = 0 "Offset at the output [A] the source gives none";
  parameter Types.Voltage v_ref = 5 "Supply [S] figure 4.7: 5 V";
  Interfaces.Pin in_p "Input";
  Interfaces.Pin in_n "Inverted input";
  Interfaces.Pin out "Output, against ground";
equation
  in_p.i = 0;
  in_n.i = 0;
  out.v = min(max(0, (1 + gain_error)*A*(in_p.v - in_n.v) + v_offset), v_ref);
end Amplifier;

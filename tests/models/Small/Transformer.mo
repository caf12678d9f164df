within Small;
model Transformer "Two coupled coils: the secondary feeds a resistor"
  input Parts.Voltage u(start=0) "Primary voltage";
  output Parts.Current i_1(start=0, fixed=true) "Primary current";
  output Parts.Current i_2(start=0, fixed=true) "Secondary current";
  parameter Parts.Inductance L_1 = 0.4 "Primary inductance";
  parameter Parts.Inductance L_2 = 0.1 "Secondary inductance";
  parameter Parts.Inductance M = 0.19 "Mutual inductance, smaller than sqrt(L_1*L_2)";
  parameter Parts.Resistance R_1 = 2 "Resistance of the primary";
  parameter Parts.Resistance R_2 = 5 "Load and resistance of the secondary";
equation
  // Faraday's law of both coils
  u - R_1*i_1 = L_1*der(i_1) + M*der(i_2);
  -R_2*i_2 = M*der(i_1) + L_2*der(i_2);
end Transformer;

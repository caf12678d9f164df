within WiperDrive.Electronics;
model SenseCircuit "Sense resistor, amplifier and low-pass as a circuit: what CurrentInput computes sample by sample"
  parameter Types.Resistance R_sense = 0.01 "Sense resistor [A] usual: 1 W at 10 A";
  parameter Types.Ratio A_sense = 50 "Nominal gain of the amplifier [A] 10 A then fill the input of 5 V";
  parameter Types.Ratio gain_error = 0 "Relative error of resistor and gain together [A] the source gives none";
  parameter Types.Voltage v_offset = 0 "Offset at the amplifier's output [A] the source gives none";
  parameter Types.Voltage v_ref = 5 "Supply of the amplifier [S] figure 4.7: 5 V";
  parameter Types.Frequency f_lowpass = 50 "Cross-over frequency of the low-pass [S] 2.4.2: about 50 Hz";
  parameter Types.Resistance R_lowpass = 10000 "Resistor of the low-pass [A] usual";
  Interfaces.Pin p "From the motor";
  Interfaces.Pin n "Return";
  Types.Voltage v "Voltage at the converter";
  Types.Current i "Current that this voltage stands for";
  Electrical.Resistor sense(R=R_sense) "Sense resistor";
  Amplifier amplifier(A=A_sense, gain_error=gain_error, v_offset=v_offset, v_ref=v_ref) "Amplifier";
  Electrical.Resistor resistor(R=R_lowpass) "Resistor of the low-pass";
  Electrical.Capacitor capacitor(C=1/(2*Constants.pi*f_lowpass*R_lowpass), v(start=max(0, v_offset), fixed=true))
    "Capacitor of the low-pass, at rest at the start";
  Electrical.Ground ground "Ground of the unit";
equation
  connect(p, sense.p);
  connect(sense.n, n);
  connect(sense.p, amplifier.in_p);
  connect(sense.n, amplifier.in_n);
  connect(amplifier.out, resistor.p);
  connect(resistor.n, capacitor.p);
  connect(capacitor.n, ground.p);
  v = capacitor.v;
  i = v/(A_sense*R_sense);
end SenseCircuit;

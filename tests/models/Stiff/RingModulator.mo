within Stiff;
model RingModulator "Four diodes mix two signals: E. H. Horneber 1976; test set II-12, with C_s > 0 an ODE"
  output Parts.Voltage u[7](each start=0, each fixed=true) "Voltages of the capacitances C, C, C_s, C_s, C_s, C_s, C_p";
  output Parts.Current i[8](each start=0, each fixed=true, each nominal=1e-3)
    "Currents of the inductances L_h, L_h, L_s2, L_s3, L_s2, L_s3, L_s1, L_s1";
  parameter Parts.Capacitance C = 1.6e-8 "Capacitance of a transformer's winding";
  parameter Parts.Capacitance C_s = 2e-12 "Parasitic capacitance of a diode's node";
  parameter Parts.Capacitance C_p = 1e-8 "Capacitance of the output";
  parameter Parts.Resistance R = 25000 "Loss of a transformer";
  parameter Parts.Resistance R_p = 50 "Loss of the output";
  parameter Parts.Inductance L_h = 4.45 "Main inductance";
  parameter Parts.Inductance L_s1 = 0.002 "Stray inductance, outer winding";
  parameter Parts.Inductance L_s2 = 5e-4 "Stray inductance, inner winding";
  parameter Parts.Inductance L_s3 = 5e-4 "Stray inductance, inner winding";
  parameter Parts.Resistance R_g1 = 36.3 "Resistance of the outer winding";
  parameter Parts.Resistance R_g2 = 17.3 "Resistance of the inner winding";
  parameter Parts.Resistance R_g3 = 17.3 "Resistance of the inner winding";
  parameter Parts.Resistance R_i = 50 "Resistance of the signal";
  parameter Parts.Resistance R_c = 600 "Resistance of the receiver";
  parameter Parts.Current gamma = 40.67286402e-9 "Saturation current of a diode";
  parameter Real delta(unit="1/V") = 17.7493332 "Inverse thermal voltage of a diode";
  Parts.Voltage u_in1 "Signal of 1 kHz";
  Parts.Voltage u_in2 "Carrier of 10 kHz";
  Parts.Voltage u_d[4] "Voltages of the diodes";
  Parts.Current q[4] "Currents of the diodes";
protected
  constant Real pi(unit="rad/s") = 3.14159265358979323846 "Half a turn per second";
equation
  u_in1 = 0.5*sin(2000*pi*time);
  u_in2 = 2*sin(20000*pi*time);
  u_d[1] = u[3] - u[5] - u[7] - u_in2;
  u_d[2] = -u[4] + u[6] - u[7] - u_in2;
  u_d[3] = u[4] + u[5] + u[7] + u_in2;
  u_d[4] = -u[3] - u[6] + u[7] + u_in2;
  for k in 1:4 loop
    q[k] = gamma*(exp(delta*u_d[k]) - 1);
  end for;
  C*der(u[1]) = i[1] - 0.5*i[3] + 0.5*i[4] + i[7] - u[1]/R;
  C*der(u[2]) = i[2] - 0.5*i[5] + 0.5*i[6] + i[8] - u[2]/R;
  C_s*der(u[3]) = i[3] - q[1] + q[4];
  C_s*der(u[4]) = -i[4] + q[2] - q[3];
  C_s*der(u[5]) = i[5] + q[1] - q[3];
  C_s*der(u[6]) = -i[6] - q[2] + q[4];
  C_p*der(u[7]) = -u[7]/R_p + q[1] + q[2] - q[3] - q[4];
  L_h*der(i[1]) = -u[1];
  L_h*der(i[2]) = -u[2];
  L_s2*der(i[3]) = 0.5*u[1] - u[3] - R_g2*i[3];
  L_s3*der(i[4]) = -0.5*u[1] + u[4] - R_g3*i[4];
  L_s2*der(i[5]) = 0.5*u[2] - u[5] - R_g2*i[5];
  L_s3*der(i[6]) = -0.5*u[2] + u[6] - R_g3*i[6];
  L_s1*der(i[7]) = -u[1] + u_in1 - (R_i + R_g1)*i[7];
  L_s1*der(i[8]) = -u[2] - (R_c + R_g1)*i[8];
end RingModulator;

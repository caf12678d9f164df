within Stiff;
model Pollution "Air pollution, 25 reactions of 20 species: J. G. Verwer 1994; test set II-2. A second stands for a minute"
  output Parts.Amount y[20](
    start={0, 0.2, 0, 0.04, 0, 0, 0.1, 0.3, 0.01, 0, 0, 0, 0, 0, 0, 0, 0.007, 0, 0, 0},
    each fixed=true,
    each nominal=1e-4) "NO2, NO, O3P, O3, HO2, OH, HCHO, CO, ALD, MEO2, C2O3, CO2, PAN, CH3O, HNO3, O1D, SO2, SO4, NO3, N2O5";
  parameter Parts.Rate k[25] = {0.35, 26.6, 12300, 0.86e-3, 0.82e-3, 15000, 0.13e-3, 24000, 16500, 9000, 0.022, 12000,
    1.88, 16300, 4.8e6, 0.35e-3, 0.0175, 1e8, 4.44e11, 1240, 2.1, 5.78, 0.0474, 1780, 3.12} "Rate constants";
  Parts.Rate r[25] "Rates of the reactions";
equation
  r[1] = k[1]*y[1];
  r[2] = k[2]*y[2]*y[4];
  r[3] = k[3]*y[5]*y[2];
  r[4] = k[4]*y[7];
  r[5] = k[5]*y[7];
  r[6] = k[6]*y[7]*y[6];
  r[7] = k[7]*y[9];
  r[8] = k[8]*y[9]*y[6];
  r[9] = k[9]*y[11]*y[2];
  r[10] = k[10]*y[11]*y[1];
  r[11] = k[11]*y[13];
  r[12] = k[12]*y[10]*y[2];
  r[13] = k[13]*y[14];
  r[14] = k[14]*y[1]*y[6];
  r[15] = k[15]*y[3];
  r[16] = k[16]*y[4];
  r[17] = k[17]*y[4];
  r[18] = k[18]*y[16];
  r[19] = k[19]*y[16];
  r[20] = k[20]*y[17]*y[6];
  r[21] = k[21]*y[19];
  r[22] = k[22]*y[19];
  r[23] = k[23]*y[1]*y[4];
  r[24] = k[24]*y[19]*y[1];
  r[25] = k[25]*y[20];
  der(y[1]) = -r[1] - r[10] - r[14] - r[23] - r[24] + r[2] + r[3] + r[9] + r[11] + r[12] + r[22] + r[25];
  der(y[2]) = -r[2] - r[3] - r[9] - r[12] + r[1] + r[21];
  der(y[3]) = -r[15] + r[1] + r[17] + r[19] + r[22];
  der(y[4]) = -r[2] - r[16] - r[17] - r[23] + r[15];
  der(y[5]) = -r[3] + 2*r[4] + r[6] + r[7] + r[13] + r[20];
  der(y[6]) = -r[6] - r[8] - r[14] - r[20] + r[3] + 2*r[18];
  der(y[7]) = -r[4] - r[5] - r[6] + r[13];
  der(y[8]) = r[4] + r[5] + r[6] + r[7];
  der(y[9]) = -r[7] - r[8];
  der(y[10]) = -r[12] + r[7] + r[9];
  der(y[11]) = -r[9] - r[10] + r[8] + r[11];
  der(y[12]) = r[9];
  der(y[13]) = -r[11] + r[10];
  der(y[14]) = -r[13] + r[12];
  der(y[15]) = r[14];
  der(y[16]) = -r[18] - r[19] + r[16];
  der(y[17]) = -r[20];
  der(y[18]) = r[20];
  der(y[19]) = -r[21] - r[22] - r[24] + r[23] + r[25];
  der(y[20]) = -r[25] + r[24];
end Pollution;

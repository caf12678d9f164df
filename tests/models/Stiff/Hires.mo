within Stiff;
model Hires "High irradiance response of a plant: E. Schaefer 1975; test set II-7, HW IV.10"
  output Parts.Amount y[8](start={1, 0, 0, 0, 0, 0, 0, 0.0057}, each fixed=true, each nominal=1e-4)
    "Phytochrome red, far-red, and their bound forms; the last is the enzyme";
  parameter Parts.Rate k1 = 1.71 "Red to far-red";
  parameter Parts.Rate k2 = 0.43 "Far-red to red";
  parameter Parts.Rate k3 = 8.32 "Bound red to bound far-red";
  parameter Parts.Rate k4 = 0.69 "Decay of the complex to bound far-red";
  parameter Parts.Rate k5 = 0.035 "Loss from the receptor";
  parameter Parts.Rate k6 = 8.32 "Binding to the receptor";
  parameter Parts.Rate k_plus = 280 "Formation of the complex";
  parameter Parts.Rate k_minus = 0.69 "Decay of the complex";
  parameter Parts.Rate k_star = 0.69 "Consumption of the complex";
  parameter Parts.Rate o_ks = 0.0007 "Supply";
equation
  der(y[1]) = -k1*y[1] + k2*y[2] + k6*y[3] + o_ks;
  der(y[2]) = k1*y[1] - (k2 + k3)*y[2];
  der(y[3]) = -(k6 + k1)*y[3] + k2*y[4] + k5*y[5];
  der(y[4]) = k3*y[2] + k1*y[3] - (k2 + k4)*y[4];
  der(y[5]) = -(k1 + k5)*y[5] + k2*(y[6] + y[7]);
  der(y[6]) = -k_plus*y[6]*y[8] + k4*y[4] + k1*y[5] - k2*y[6] + k_minus*y[7];
  der(y[7]) = k_plus*y[6]*y[8] - (k2 + k_minus + k_star)*y[7];
  der(y[8]) = -der(y[7]);
end Hires;

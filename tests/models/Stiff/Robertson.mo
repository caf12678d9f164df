within Stiff;
model Robertson "Autocatalytic reaction over eleven decades of time: H. H. Robertson 1966; test set II-10, HW IV.10"
  output Parts.Amount y1(start=1, fixed=true, nominal=1e-8) "Reactant";
  output Parts.Amount y2(start=0, fixed=true, nominal=1e-14) "Catalyst";
  output Parts.Amount y3(start=0, fixed=true) "Product";
  parameter Parts.Rate k1 = 0.04 "y1 -> y2";
  parameter Parts.Rate k2 = 3e7 "y2 + y2 -> y3 + y2";
  parameter Parts.Rate k3 = 1e4 "y2 + y3 -> y1 + y3";
equation
  der(y1) = -k1*y1 + k3*y2*y3;
  der(y2) = k1*y1 - k3*y2*y3 - k2*y2^2;
  der(y3) = k2*y2^2;
end Robertson;

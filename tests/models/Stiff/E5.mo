within Stiff;
model E5 "Pyrolysis over 13 decades of time: W. H. Enright, T. E. Hull, B. Lindberg 1975; test set II-11, HW IV.10"
  output Parts.Amount y1(start=1.76e-3, fixed=true, nominal=1e-24) "Reactant";
  output Parts.Amount y2(start=0, fixed=true, nominal=1e-24) "Product of the first reaction";
  output Parts.Amount y3(nominal=1e-24) "Radical";
  output Parts.Amount y4(start=0, fixed=true, nominal=1e-24) "Intermediate";
  parameter Parts.Rate A = 7.89e-10 "y1 -> y2 + y3";
  parameter Parts.Rate B = 1.1e7 "y1 + y3 -> y4";
  parameter Parts.Rate C = 1.13e3 "y4 -> y3";
  parameter Real M(unit="1") = 1e6 "Relative rate of y2 + y3 ->";
equation
  der(y1) = -A*y1 - B*y1*y3;
  der(y2) = A*y1 - M*C*y2*y3;
  der(y4) = B*y1*y3 - C*y4;
  // der(y3) = der(y2) - der(y4), integrated: the difference of rates would drown in rounding
  y3 = y2 - y4;
end E5;

within Small;
model Logistic "Growth to a limit, with a harvest that the stock limits"
  output Real N(unit="1", start=10, fixed=true) "Stock";
  output Real harvested(unit="1", start=0, fixed=true) "Harvest so far";
  parameter Real r(unit="1/s") = 0.8 "Rate of growth";
  parameter Real K(unit="1") = 1000 "Limit of growth";
  parameter Real N_0(unit="1") = 600 "Stock from which harvest is at its full rate";
  parameter Real q(unit="1/s") = 0 "Full harvest";
  Real h(unit="1/s") "Harvest";
equation
  h = q*min(N, N_0);
  der(N) = r*N*(1 - N/K) - h;
  der(harvested) = h;
end Logistic;

within Stiff;
model VanDerPol "Relaxation oscillation, mu = 1000: B. van der Pol 1926; test set II-1, HW IV.10"
  output Real x(start=2, fixed=true, unit="1") "Deflection";
  output Real v(start=0, fixed=true, unit="1/s", nominal=1e-3) "Its rate";
  parameter Real mu(unit="1") = 1000 "Damping ratio";
  parameter Real w(unit="1/s") = 1 "Frequency of the undamped oscillation";
equation
  der(x) = v;
  der(v) = mu*w*(1 - x^2)*v - w^2*x;
end VanDerPol;

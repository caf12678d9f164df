within Stiff;
model VanDerPolScaled "Relaxation oscillation in the time of its period, eps = 1e-6: HW IV.10, problem VDPOL"
  output Real x(start=2, fixed=true, unit="1") "Deflection";
  output Real v(start=0, fixed=true, unit="1/s") "Its rate";
  parameter Real eps(unit="1") = 1e-6 "Inverse square of the damping ratio";
  parameter Real w(unit="1/s") = 1 "Inverse unit of time";
equation
  der(x) = v;
  eps*der(v) = w*(1 - x^2)*v - w^2*x;
end VanDerPolScaled;

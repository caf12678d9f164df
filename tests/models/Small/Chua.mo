within Small;
model Chua "Chua's circuit in its dimensionless form: a resistor with three slopes"
  output Real x(unit="1", start=0.7, fixed=true) "Voltage of the first capacitor";
  output Real y(unit="1", start=0, fixed=true) "Voltage of the second capacitor";
  output Real z(unit="1", start=0, fixed=true) "Current of the coil";
  parameter Real alpha(unit="1/s") = 9 "Ratio of the capacitors";
  parameter Real beta(unit="1/s") = 100/7 "Coil";
  parameter Real one(unit="1/s") = 1 "Unit of time";
  parameter Real m_0(unit="1") = -8/7 "Slope inside";
  parameter Real m_1(unit="1") = -5/7 "Slope outside";
  Real f(unit="1") "Current of the resistor";
equation
  f = if x > 1 then m_1*x + m_0 - m_1 elseif x < -1 then m_1*x - m_0 + m_1 else m_0*x;
  der(x) = alpha*(y - x - f);
  der(y) = one*(x - y + z);
  der(z) = -beta*y;
end Chua;

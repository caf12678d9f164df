within Stiff;
model Oregonator "Belousov-Zhabotinskii reaction: R. J. Field, R. M. Noyes 1974; test set II-9, HW IV.10, problem OREGO"
  output Parts.Amount y1(start=1, fixed=true) "HBrO2";
  output Parts.Amount y2(start=2, fixed=true) "Br-";
  output Parts.Amount y3(start=3, fixed=true) "Ce(IV)";
  parameter Parts.Rate s = 77.27 "Rate of the fast reactions";
  parameter Parts.Rate w = 0.161 "Rate of the slow one";
  parameter Real q(unit="1") = 8.375e-6 "Self-destruction of HBrO2";
equation
  der(y1) = s*(y2 + y1*(1 - q*y1 - y2));
  s*der(y2) = (y3 - (1 + y1)*y2)*one^2;
  der(y3) = w*(y1 - y3);
protected
  constant Parts.Rate one = 1 "Inverse unit of time";
end Oregonator;

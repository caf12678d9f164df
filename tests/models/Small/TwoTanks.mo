within Small;
model TwoTanks "Two tanks joined by a valve, until their levels are nearly equal"
  output Parts.Length h_1(start=2, fixed=true) "Level of the first tank";
  output Parts.Length h_2(start=0.5, fixed=true) "Level of the second tank";
  output Real V(unit="m3") "Volume in both";
  parameter Real A_1(unit="m2") = 1 "Area of the first tank";
  parameter Real A_2(unit="m2") = 2 "Area of the second tank";
  parameter Real k(unit="m2") = 0.05 "Open area of the valve";
  constant Parts.Acceleration g = 9.81 "Gravity";
  Real q(unit="m3/s") "Flow from the first tank to the second";
equation
  // Torricelli's law
  q = k*sqrt(2*g*(h_1 - h_2));
  // conservation of mass
  A_1*der(h_1) = -q;
  A_2*der(h_2) = q;
  V = A_1*h_1 + A_2*h_2;
end TwoTanks;

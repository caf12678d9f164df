within Small;
model Rod "Heat in a rod, cut into cells: arrays and for-equations"
  constant Integer n = 8 "Number of cells";
  parameter Real a(unit="1/s") = 5 "Conduction between cells";
  output Real T[n](each unit="K", each start=0, each fixed=true) "Temperatures";
  output Real mean(unit="K") "Mean temperature";
  output Real total(unit="K") "Sum";
  Real q[n + 1](each unit="K/s") "Flow into each cell from the left";
equation
  q[1] = a*(1 - T[1]);
  for i in 2:n loop
    q[i] = a*(T[i - 1] - T[i]);
  end for;
  q[n + 1] = 0;
  for i in 1:n loop
    der(T[i]) = q[i] - q[i + 1];
  end for;
  total = sum(T);
  mean = total/n;
end Rod;

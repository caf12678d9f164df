within Small;
model HeatModes "Heat in a wall with cold faces, cut into cells; it starts as a sum of two modes"
  constant Integer n = 20 "Number of cells inside";
  constant Real pi(unit="1") = 3.141592653589793 "Circle";
  parameter Real a(unit="1/s") = 30 "Conduction between cells";
  parameter Real T_0(unit="K") = 1 "Amplitude of the first mode";
  output Real T[n](each unit="K", each fixed=true, start={T_0*sin(pi*k/(n + 1)) + T_0/2*sin(3*pi*k/(n + 1)) for k in 1:n})
    "Temperatures above that of the faces";
equation
  der(T[1]) = a*(T[2] - 2*T[1]);
  for k in 2:n - 1 loop
    der(T[k]) = a*(T[k - 1] - 2*T[k] + T[k + 1]);
  end for;
  der(T[n]) = a*(T[n - 1] - 2*T[n]);
end HeatModes;

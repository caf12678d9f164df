within Split;
model RadiatingBody "A body that takes up radiation and cools in air: temperature in, heat out at once"
  input Types.Temperature T1(start=350) "Temperature of the source";
  output Types.Power q "Heat that it takes up";
  output Types.Temperature T(start=300, fixed=true) "Temperature";
  parameter Types.HeatCapacity C = 15 "Heat capacity";
  parameter Types.Exchange s = 5.67e-8 "Area times the constant of Stefan and Boltzmann, for black surfaces";
  parameter Types.Conductance G = 8 "To the air";
  parameter Types.Temperature T_air = 290 "Temperature of the air";
equation
  // law of Stefan and Boltzmann
  q = s*(T1^4 - T^4);
  // balance of heat
  C*der(T) = q - G*(T - T_air);
end RadiatingBody;

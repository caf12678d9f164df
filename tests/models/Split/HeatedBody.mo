within Split;
model HeatedBody "A body with a heater of which the power swings; the heat that it loses is an input"
  input Types.Power q(start=0) "Heat that it loses";
  output Types.Temperature T(start=350, fixed=true) "Temperature";
  parameter Types.HeatCapacity C = 10 "Heat capacity";
  parameter Types.Power P = 400 "Mean power of the heater";
  parameter Types.Frequency w = 4 "Angular frequency of the power";
equation
  // balance of heat
  C*der(T) = P*(1 + sin(w*time)) - q;
end HeatedBody;

within Split;
model TwoMasses "Both masses and their coupling in one: what the two parts, and the two masses beside each other, make up"
  output Types.Length x1 "Place of the first mass";
  output Types.Velocity v1 "Velocity of the first mass";
  output Types.Length x2 "Place of the second mass";
  output Types.Velocity v2 "Velocity of the second mass";
  output Types.Force F "Force of the coupling on the first mass";
  MassOnSpring first(F=F) "First mass";
  MassWithCoupling second(x1=x1, v1=v1) "Second mass";
equation
  F = second.F;
  x1 = first.x;
  v1 = first.v;
  x2 = second.x;
  v2 = second.v;
end TwoMasses;

within Small;
model Coupled "Two places rigidly coupled by a factor: the modeller's wish decides which is the state"
  parameter Real k = 3 "Factor";
  Parts.Length x(start=1, fixed=true, stateSelect=StateSelect.avoid) "First place";
  Parts.Length z(stateSelect=StateSelect.prefer) "Second place";
  output Parts.Velocity v "Speed of the second place";
  Real F(unit="N") "Force of the coupling";
equation
  der(x) = -2*x + F;
  der(z) = -F;
  z = k*x;
  v = der(z);
end Coupled;

within Small;
model Coupled "Two places rigidly coupled by a factor: the modeller's wish decides which is the state"
  parameter Real k(unit="1") = 3 "Factor";
  constant Real a(unit="1/s") = 2 "Rate at which the first place falls";
  Parts.Length x(start=1, fixed=true, stateSelect=StateSelect.avoid) "First place";
  Parts.Length z(stateSelect=StateSelect.prefer) "Second place";
  output Parts.Velocity v "Speed of the second place";
  Parts.Velocity F "What the coupling gives to the one and takes from the other";
equation
  der(x) = -a*x + F;
  der(z) = -F;
  z = k*x;
  v = der(z);
end Coupled;

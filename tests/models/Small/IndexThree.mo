within Small;
model IndexThree "The force that leads a cart along a given path: index 3, without a state"
  output Parts.Length x "Place";
  output Parts.Velocity v "Speed";
  output Parts.Force F "Force";
  parameter Parts.Mass m = 2 "Mass";
  parameter Real d(unit="N.s/m") = 0.5 "Friction";
  parameter Real w(unit="rad/s") = 3 "Angular frequency";
  constant Parts.Length amplitude = 1 "Amplitude";
equation
  v = der(x);
  m*der(v) = F - d*v;
  x = amplitude*(sin(w*time) + exp(-w*time));
end IndexThree;

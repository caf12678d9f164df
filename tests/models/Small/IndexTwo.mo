within Small;
model IndexTwo "Two lags driven so that their sum follows a sine: index 2"
  output Real x(unit="1", start=0.5, fixed=true) "First lag";
  output Real y(unit="1") "Second lag";
  output Real u(unit="1") "What drives both";
  parameter Parts.Time T_1 = 1 "Time constant of the first lag";
  parameter Parts.Time T_2 = 3 "Time constant of the second lag";
  parameter Real w(unit="rad/s") = 2 "Angular frequency";
equation
  T_1*der(x) = u - x;
  T_2*der(y) = u - y;
  x + y = sin(w*time);
end IndexTwo;

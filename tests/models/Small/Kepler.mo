within Small;
model Kepler "A planet on an ellipse"
  parameter Real mu(unit="m3/s2") = 1 "Gravitational parameter";
  parameter Parts.Length a = 1 "Semi-major axis";
  parameter Real e(unit="1") = 0.6 "Eccentricity";
  output Parts.Length x(start=a*(1 - e), fixed=true) "Place, from the focus to the perihelion";
  output Parts.Length y(start=0, fixed=true) "Place, across";
  output Parts.Velocity v_x(start=0, fixed=true) "Speed";
  output Parts.Velocity v_y(start=sqrt(mu/a*(1 + e)/(1 - e)), fixed=true) "Speed";
  output Real H(unit="m2/s2") "Energy of a unit of mass";
  output Real L(unit="m2/s") "Angular momentum of a unit of mass";
  Parts.Length r "Distance";
equation
  r = sqrt(x^2 + y^2);
  der(x) = v_x;
  der(y) = v_y;
  // Newton's law of gravitation
  der(v_x) = -mu*x/r^3;
  der(v_y) = -mu*y/r^3;
  H = (v_x^2 + v_y^2)/2 - mu/r;
  L = x*v_y - y*v_x;
end Kepler;

within Small;
model DoublePendulum "Two rods without mass, two points of mass, in Cartesian coordinates"
  constant Parts.Acceleration g = 9.81 "Gravity";
  parameter Parts.Length L = 1 "Length of each rod";
  parameter Parts.Mass m = 1 "Mass of each point";
  output Parts.Angle a(start=0.4, fixed=true, stateSelect=StateSelect.always) "Angle of the upper rod";
  output Parts.Angle b(start=-0.3, fixed=true, stateSelect=StateSelect.always) "Angle of the lower rod";
  output Parts.AngularVelocity wa(start=0, fixed=true, stateSelect=StateSelect.always) "Speed of the upper rod";
  output Parts.AngularVelocity wb(start=0, fixed=true, stateSelect=StateSelect.always) "Speed of the lower rod";
  output Parts.Energy E "Energy";
  Parts.Length r[2, 2] "Places of the points, one a row";
  Parts.Velocity v[2, 2] "Velocities";
  Real F[2](each unit="N") "Tension of the rods";
equation
  wa = der(a);
  wb = der(b);
  r[1, 1] = L*sin(a);
  r[1, 2] = -L*cos(a);
  r[2, 1] = r[1, 1] + L*sin(b);
  r[2, 2] = r[1, 2] - L*cos(b);
  v = der(r);
  m*der(v[1, 1]) = -F[1]*sin(a) + F[2]*sin(b);
  m*der(v[1, 2]) = F[1]*cos(a) - F[2]*cos(b) - m*g;
  m*der(v[2, 1]) = -F[2]*sin(b);
  m*der(v[2, 2]) = F[2]*cos(b) - m*g;
  E = m*(v[1, 1]^2 + v[1, 2]^2 + v[2, 1]^2 + v[2, 2]^2)/2 + m*g*(r[1, 2] + r[2, 2]);
end DoublePendulum;

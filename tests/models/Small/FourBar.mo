within Small;
model FourBar "A planar four-bar linkage whose crank turns all the way; the rocker has a moment of inertia"
  parameter Parts.Length a = 0.1 "Crank";
  parameter Parts.Length b = 0.4 "Coupler";
  parameter Parts.Length c = 0.25 "Rocker";
  parameter Parts.Length d = 0.4 "Base";
  parameter Parts.MomentOfInertia J_1 = 0.02 "Inertia of the crank";
  parameter Parts.MomentOfInertia J_3 = 0.05 "Inertia of the rocker";
  input Parts.Torque tau(start=0) "Torque on the crank";
  output Parts.Angle phi(start=0, fixed=true, stateSelect=StateSelect.always) "Angle of the crank";
  output Parts.AngularVelocity w(start=6, fixed=true, stateSelect=StateSelect.always) "Speed of the crank";
  output Parts.Angle theta(start=0.7) "Angle of the coupler";
  output Parts.Angle psi(start=1.7) "Angle of the rocker";
  output Parts.AngularVelocity w_3 "Speed of the rocker";
  output Parts.Energy E "Kinetic energy";
  Parts.Force F_x "Force of the coupler on the rocker";
  Parts.Force F_y "Force of the coupler on the rocker";
equation
  // closed loop
  a*cos(phi) + b*cos(theta) = d + c*cos(psi);
  a*sin(phi) + b*sin(theta) = c*sin(psi);
  w = der(phi);
  w_3 = der(psi);
  // the massless coupler passes the force along itself
  0 = F_x*sin(theta) - F_y*cos(theta);
  J_3*der(w_3) = c*(F_y*cos(psi) - F_x*sin(psi));
  J_1*der(w) = tau - a*(F_y*cos(phi) - F_x*sin(phi));
  E = (J_1*w^2 + J_3*w_3^2)/2;
end FourBar;

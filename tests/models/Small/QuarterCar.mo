within Small;
model QuarterCar "A quarter of a car drives onto a step"
  input Parts.Length road(start=0) "Height of the road";
  output Parts.Length z_body(start=0, fixed=true) "Height of the body";
  output Parts.Length z_wheel(start=0, fixed=true) "Height of the wheel";
  Parts.Velocity v_body(start=0, fixed=true) "Speed of the body";
  Parts.Velocity v_wheel(start=0, fixed=true) "Speed of the wheel";
  Parts.Force F "Force of spring and damper on the body";
  parameter Parts.Mass m_body = 300 "Quarter of the body";
  parameter Parts.Mass m_wheel = 40 "Wheel";
  parameter Real c_body(unit="N/m") = 2e4 "Stiffness of the spring";
  parameter Real d_body(unit="N.s/m") = 1500 "Damping";
  parameter Real c_tyre(unit="N/m") = 2e5 "Stiffness of the tyre";
equation
  v_body = der(z_body);
  v_wheel = der(z_wheel);
  F = c_body*(z_wheel - z_body) + d_body*(v_wheel - v_body);
  m_body*der(v_body) = F;
  m_wheel*der(v_wheel) = c_tyre*(road - z_wheel) - F;
end QuarterCar;

package Drive "A DC motor and its speed controller"
  model Motor "Permanent-magnet DC motor with a constant load"
    parameter Real R(unit = "Ohm") = 1 "Resistance";
    parameter Real L(unit = "H") = 1e-3 "Inductance";
    parameter Real k(unit = "N.m/A") = 0.05 "Torque constant";
    parameter Real J(unit = "kg.m2") = 1e-4 "Inertia";
    parameter Real b(unit = "N.m.s/rad") = 1e-5 "Viscous friction";
    parameter Real tau(unit = "N.m") = 0.02 "Load torque";
    input Real u(unit = "V") "Voltage";
    output Real w(unit = "rad/s", start = 0, fixed = true) "Speed";
    output Real i(unit = "A", start = 0, fixed = true) "Current";
  equation
    L*der(i) = u - R*i - k*w "mesh rule";
    J*der(w) = k*i - b*w - tau "balance of torques";
  end Motor;

  model Regulator "PI controller"
    parameter Real Kp(unit = "V.s/rad") = 0.5 "Gain";
    parameter Real Ki(unit = "V/rad") = 5 "Integral gain";
    input Real w(unit = "rad/s") "Speed";
    output Real u(unit = "V") "Voltage";
  protected
    Real x(unit = "V", start = 0, fixed = true) "Integral";
    Real e(unit = "rad/s") "Control deviation";
  equation
    e = 25 + 75*sin(2.5*time) - w "so that no step is like the one before";
    der(x) = Ki*e;
    u = Kp*e + x;
  end Regulator;
end Drive;

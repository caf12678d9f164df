within Small;
model SampledPI "A sampled PI controller on a lag"
  input Real w(start=1) "Reference";
  output Real y(start=0, fixed=true) "Controlled variable";
  output Real u(start=0, fixed=true) "Controller's output, held";
  parameter Real k = 2 "Gain";
  parameter Parts.Time T_i = 0.5 "Integral time";
  parameter Parts.Time T_s = 0.1 "Sample time";
  parameter Parts.Time T = 0.4 "Time constant of the lag";
  discrete Real x(start=0, fixed=true) "Integrator";
  Real e "Error";
equation
  e = w - y;
  when sample(0, T_s) then
    x = pre(x) + T_s*e/T_i;
    u = k*(e + x);
  end when;
  T*der(y) + y = u;
end SampledPI;

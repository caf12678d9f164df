within Loops;
model Block "Outputs that follow the inputs without delay, one for each kind of loop"
  type Voltage = Real(unit="V") "Voltage";
  input Voltage u(start=0.5) "First input";
  input Voltage v(start=0) "Second input";
  input Boolean on(start=false) "Switches the switched output";
  output Voltage affine "k u + m v + b";
  output Voltage wave "k u + sine of time";
  output Voltage cosine "cos(u)";
  output Voltage square "c u^2 + b";
  output Voltage implicit "Solution y of y + sin(y)/2 = u";
  output Voltage switched "Switched between two voltages, and u";
  output Boolean above "The first input is above its threshold";
  output Boolean not_on "The opposite of what switches";
  parameter Real k = 1 "Gain of the first input";
  parameter Real m = 0 "Gain of the second input";
  parameter Real c(unit="1/V") = 1 "Coefficient of the square";
  parameter Voltage b = 0 "Offset";
  parameter Voltage threshold = 1 "Threshold";
  parameter Voltage high = 2 "Output while switched on";
  parameter Voltage low = 0 "Output while switched off";
protected
  constant Voltage one = 1 "Unit of voltage";
equation
  affine = k*u + m*v + b;
  wave = k*u + one*sin(time);
  cosine = one*cos(u/one);
  square = c*u^2 + b;
  implicit + one*sin(implicit/one)/2 = u;
  switched = k*u + (if on then high else low);
  above = u > threshold;
  not_on = not on;
end Block;

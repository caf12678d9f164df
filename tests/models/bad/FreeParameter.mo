model FreeParameter "A parameter that an initial equation would have to find"
  parameter Real p(unit="1", fixed=false, start=1) "To be found";
  Real x(unit="1", start=2, fixed=true) "State";
initial equation
  p = 3*x;
equation
  der(x) = -p*x;
end FreeParameter;

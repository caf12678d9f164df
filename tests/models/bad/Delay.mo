model Delay "Needs the past of a variable"
  Real x(unit="1", start=1, fixed=true) "State";
equation
  der(x) = -delay(x, 0.1);
end Delay;

model NoUnit "A unit that is not one"
  Real x(unit="grumble/s", start=1, fixed=true) "State";
equation
  der(x) = -x;
end NoUnit;

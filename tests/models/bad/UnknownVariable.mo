model UnknownVariable "Uses a name that is not declared"
  Real x(unit="1", start=1, fixed=true) "State";
equation
  der(x) = -x + spede;
end UnknownVariable;

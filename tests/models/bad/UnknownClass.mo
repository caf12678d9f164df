model UnknownClass "Has a component of a class that is not there"
  Real x(unit="1", start=1, fixed=true) "State";
  Gearbox gear "Not declared anywhere";
equation
  der(x) = -x;
end UnknownClass;

model UnassignedDiscrete "A Boolean that nothing gives a value"
  Real x(unit="1", start=1, fixed=true) "State";
  Boolean b "Without value";
equation
  der(x) = if b then -x else x;
end UnassignedDiscrete;

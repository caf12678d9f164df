model Message "A message made of what is no text"
  parameter Boolean loud = true "Whether to shout";
  Real x(unit="1", start=1, fixed=true) "State";
equation
  der(x) = -x;
  assert(x > 0.1, if loud then "LOW" else "low");
end Message;

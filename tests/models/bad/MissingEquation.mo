model MissingEquation "Two unknowns, one equation"
  Real x(unit="1", start=1, fixed=true) "State";
  Real force(unit="N") "Without equation";
equation
  der(x) = -x + force;
end MissingEquation;

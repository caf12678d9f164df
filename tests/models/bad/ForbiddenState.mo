model ForbiddenState "Asks for two states where there is one degree of freedom"
  Real x(unit="1", start=1, fixed=true, stateSelect=StateSelect.always) "First";
  Real y(unit="1", stateSelect=StateSelect.always) "Second";
  Real f(unit="1/s") "Coupling";
equation
  der(x) = -x + f;
  der(y) = -f;
  y = 3*x + 1;
end ForbiddenState;

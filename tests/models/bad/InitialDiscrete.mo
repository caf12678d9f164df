model InitialDiscrete "A discrete variable that starts from a state"
  Real x(unit="1", start=1, fixed=true) "State";
  discrete Real d(unit="1") "Last value";
initial equation
  d = 2*x;
equation
  der(x) = -x;
  when x < 0.5 then
    d = x;
  end when;
end InitialDiscrete;

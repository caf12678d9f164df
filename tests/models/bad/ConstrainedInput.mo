model ConstrainedInput "An input prescribes a function of a state"
  input Real u(unit="m") "Position";
  output Real x(unit="m", start=1) "State";
  Real f(unit="m/s") "Force that would be needed";
equation
  der(x) = -x + f;
  x^3 = u;
end ConstrainedInput;

model DiscreteLoop "Each Boolean is the opposite of the other's negation"
  Real x(unit="1", start=1, fixed=true) "State";
  Boolean a "First";
  Boolean b "Second";
equation
  der(x) = -x;
  a = b or x < 0.5;
  b = a and x < 0.7;
end DiscreteLoop;

model InitialState "An initial algorithm that assigns a state"
  Real x(unit="1") "State";
initial algorithm
  x := 2;
equation
  der(x) = -x;
end InitialState;

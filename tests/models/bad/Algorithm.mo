model Algorithm "An assignment in an algorithm outside when"
  Real x(unit="1", start=1, fixed=true) "State";
  Real y(unit="1") "Twice the state";
algorithm
  y := 2*x;
equation
  der(x) = -y;
end Algorithm;

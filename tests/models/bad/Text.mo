model Text "Has a String variable"
  Real x(unit="1", start=1, fixed=true) "State";
  parameter String name = "x" "Name";
equation
  der(x) = -x;
end Text;

model Text "Has a String variable that changes"
  Real x(unit="1", start=1, fixed=true) "State";
  String name "Name of the range";
equation
  der(x) = -x;
  name = if x > 0.5 then "high" else "low";
end Text;

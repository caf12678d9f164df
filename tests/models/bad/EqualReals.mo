model EqualReals "Compares Reals with =="
  Real x(unit="1", start=1, fixed=true) "State";
  Boolean b "Comparison";
equation
  der(x) = -x;
  b = x == 0.5;
end EqualReals;

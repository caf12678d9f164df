model OutOfRange "An index beyond the array"
  Real x[3](each unit="1", each start=1, each fixed=true) "States";
equation
  der(x[1]) = -x[1];
  der(x[2]) = -x[4];
  der(x[3]) = -x[2];
end OutOfRange;

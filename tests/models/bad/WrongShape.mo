model WrongShape "Adds arrays of different sizes"
  Real x[3](each unit="1", each start=1, each fixed=true) "States";
  parameter Real k[2](each unit="1/s") = {1, 2} "Two numbers for three states";
equation
  der(x) = -k;
end WrongShape;

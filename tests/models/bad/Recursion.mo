model Recursion "Calls a function that calls itself"
  function factorial "Factorial"
    input Integer n "Argument";
    output Integer y "Result";
  algorithm
    y := if n <= 1 then 1 else n*factorial(n - 1);
  end factorial;
  Real x(unit="1", start=1, fixed=true) "State";
equation
  der(x) = -factorial(3)*x;
end Recursion;

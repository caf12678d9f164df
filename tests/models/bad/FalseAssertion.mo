model FalseAssertion "A function whose assertion the parameter's default violates"
  function root "Square root"
    input Real u "Argument";
    output Real y "Result";
  algorithm
    assert(u >= 0, "root of a negative number");
    y := sqrt(u);
  end root;
  constant Real k = -4 "Argument";
  Real x(unit="1", start=1, fixed=true) "State";
equation
  der(x) = -root(k)*x;
end FalseAssertion;

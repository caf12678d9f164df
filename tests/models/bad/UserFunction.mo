model UserFunction "Calls a function of its own"
  function square "Square"
    input Real u "Argument";
    output Real y "Result";
  algorithm
    y := u*u;
  end square;
  Real x(unit="1", start=1, fixed=true) "State";
equation
  der(x) = -square(x);
end UserFunction;

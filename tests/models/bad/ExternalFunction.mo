model ExternalFunction "Calls a function in C"
  function cubicRoot "Cubic root"
    input Real u "Argument";
    output Real y "Result";
  external "C" y = cbrt(u);
  end cubicRoot;
  Real x(unit="1", start=1, fixed=true) "State";
equation
  der(x) = -cubicRoot(x);
end ExternalFunction;

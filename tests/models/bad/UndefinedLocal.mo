model UndefinedLocal "A function that uses a variable before it has a value"
  function twice "Twice the argument"
    input Real u "Argument";
    output Real y "Result";
  protected
    Real a "Never assigned";
  algorithm
    y := u + a;
  end twice;
  Real x(unit="1", start=1, fixed=true) "State";
equation
  der(x) = -twice(x);
end UndefinedLocal;

model UndefinedResult "A function that does not always give a result"
  function positive "Positive numbers only"
    input Real u "Argument";
    output Real y "Result";
  algorithm
    if u > 0 then
      y := u;
    end if;
  end positive;
  Real x(unit="1", start=1, fixed=true) "State";
equation
  der(x) = -positive(x);
end UndefinedResult;

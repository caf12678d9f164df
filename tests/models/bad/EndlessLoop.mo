model EndlessLoop "A function whose loop turns as often as an argument says"
  function rounded "Next whole number"
    input Real u "Argument";
    output Real y "Result";
  algorithm
    y := 0;
    while y < u loop
      y := y + 1;
    end while;
  end rounded;
  Real x(unit="1", start=1, fixed=true) "State";
equation
  der(x) = -rounded(x);
end EndlessLoop;

model ReinitAlgebraic "reinit of what is not a state"
  Real x(unit="1", start=1, fixed=true) "State";
  Real y(unit="1") "Not a state";
equation
  der(x) = -x;
  y = x^2;
  when x < 0.5 then
    reinit(y, 1);
  end when;
end ReinitAlgebraic;

model BranchesDiffer "An if-equation without else"
  Real x(unit="1", start=1, fixed=true) "State";
  Real y(unit="1") "Defined in one branch only";
equation
  der(x) = -x;
  if x > 0.5 then
    y = 1;
  end if;
end BranchesDiffer;

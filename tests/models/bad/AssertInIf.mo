model AssertInIf "An assertion in a branch of an if-equation"
  Real x(unit="1", start=1, fixed=true) "State";
equation
  der(x) = -x;
  if x > 0.7 then
    assert(time < 2, "too late");
  end if;
end AssertInIf;

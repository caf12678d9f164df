model Singular "As many equations as unknowns, but two of them for one unknown"
  Real x(unit="1", start=1, fixed=true) "State";
  Real a(unit="1") "Determined twice";
  Real b(unit="1") "Not determined";
  Real c(unit="1") "Not determined";
equation
  der(x) = -x;
  a = 2*x;
  a = 3*x + 1;
  b + c = x;
end Singular;

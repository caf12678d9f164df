model OuterWithoutInner "Uses what surrounds it, but nothing does"
  outer Real ambient "Temperature";
  Real x(unit="1", start=1, fixed=true) "State";
equation
  der(x) = ambient - x;
end OuterWithoutInner;

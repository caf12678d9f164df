model MixedSection "An algorithm section that uses what its when-statement assigns"
  Real x(unit="1", start=1, fixed=true) "State";
  Integer n(start=0, fixed=true) "Count";
  Real y(unit="1") "Level";
algorithm
  y := n;
  when x < 0.5 then
    n := pre(n) + 1;
  end when;
  y := y + 1;
equation
  der(x) = -x;
end MixedSection;

model RealToInteger "Assigns a Real to an Integer"
  Real y(unit="1") "Level";
  Integer n(start=0) "Whole number";
algorithm
  y := 2*time;
  n := 2.5*time;
end RealToInteger;

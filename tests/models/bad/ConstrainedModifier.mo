model ConstrainedModifier "Gives every class that may come a modifier"
  model Slow "Slow part"
    parameter Real k(unit="1/s") = 1 "Rate";
    Real x(unit="1", start=1, fixed=true) "State";
  equation
    der(x) = -k*x;
  end Slow;
  model Holder "Holds a part"
    replaceable model Part = Slow constrainedby Slow(k=3);
    Part part "Part";
  end Holder;
  Holder holder "Loses the three";
end ConstrainedModifier;

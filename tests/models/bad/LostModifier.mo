model LostModifier "Gives a redeclared class a modifier in the same place"
  model Slow "Slow part"
    parameter Real k(unit="1/s") = 1 "Rate";
    Real x(unit="1", start=1, fixed=true) "State";
  equation
    der(x) = -k*x;
  end Slow;
  model Fast "Fast part"
    extends Slow(k=2);
  end Fast;
  model Holder "Holds a part"
    replaceable model Part = Slow;
    Part part "Part";
  end Holder;
  Holder holder(redeclare model Part = Fast(k=7)) "Loses the seven";
end LostModifier;

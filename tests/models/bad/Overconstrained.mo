model Overconstrained "A connector with an overconstrained type"
  type Orientation "Orientation of a frame"
    extends Real;
    function equalityConstraint "How two orientations differ"
      input Orientation a "First";
      input Orientation b "Second";
      output Real residue[0] "Nothing";
    algorithm
    end equalityConstraint;
  end Orientation;
  connector Frame "Frame"
    Real r(unit="m") "Position";
    flow Real f(unit="N") "Force";
    Orientation o "Orientation";
  end Frame;
  Frame a "Frame";
equation
  Connections.root(a.o);
  a.r = time;
  a.o = 1;
end Overconstrained;

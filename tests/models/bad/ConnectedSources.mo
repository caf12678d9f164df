model ConnectedSources "Two ideal voltage sources in parallel"
  connector Pin "Pin"
    Real v(unit="V") "Potential";
    flow Real i(unit="A") "Current";
  end Pin;
  model Source "Ideal source"
    Pin p "Pin";
    parameter Real u(unit="V") "Voltage";
  equation
    p.v = u;
  end Source;
  Source first(u=1) "First";
  Source second(u=2) "Second";
equation
  connect(first.p, second.p);
end ConnectedSources;

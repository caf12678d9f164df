within Small;
model SeriesInductors "Two inductors carry one current, so there is one state"
  input Parts.Voltage u(start=10) "Supply";
  output Parts.Current i "Current";
  output Parts.Voltage v_2 "Voltage across the second inductor";
  Parts.VoltageSource source(u=u) "Supply";
  Parts.Resistor resistor(R=4) "Load";
  Parts.Inductor first(L=0.1, i(start=0, fixed=true)) "First";
  Parts.Inductor second(L=0.3) "Second";
  Parts.Ground ground "Chassis";
equation
  connect(source.p, resistor.p);
  connect(resistor.n, first.p);
  connect(first.n, second.p);
  connect(second.n, source.n);
  connect(source.n, ground.p);
  i = first.i;
  v_2 = second.v;
end SeriesInductors;

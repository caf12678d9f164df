within Small;
model ParallelCapacitors "Two capacitors share one voltage, so there is one state"
  input Parts.Voltage u(start=5) "Supply";
  output Parts.Voltage v "Voltage of both";
  output Parts.Current i_2 "Current of the second";
  Parts.VoltageSource source(u=u) "Supply";
  Parts.Resistor resistor(R=1000) "Load";
  Parts.Capacitor first(C=1e-4, v(start=1, fixed=true)) "First";
  Parts.Capacitor second(C=3e-4) "Second";
  Parts.Ground ground "Chassis";
equation
  connect(source.p, resistor.p);
  connect(resistor.n, first.p);
  connect(resistor.n, second.p);
  connect(first.n, source.n);
  connect(second.n, source.n);
  connect(source.n, ground.p);
  v = first.v;
  i_2 = second.i;
end ParallelCapacitors;

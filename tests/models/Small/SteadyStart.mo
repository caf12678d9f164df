within Small;
model SteadyStart "A circuit that starts at rest, whatever its parameters"
  input Parts.Voltage u(start=12) "Supply";
  output Parts.Current i "Current";
  output Parts.Voltage v "Voltage of the capacitor";
  parameter Parts.Resistance R = 3 "Series resistance";
  Parts.VoltageSource source(u=u) "Supply";
  Parts.Resistor series(R=R) "Series resistance";
  Parts.Inductor inductor(L=0.1) "Filter";
  Parts.Capacitor capacitor(C=0.01) "Filter";
  Parts.Resistor load(R=9) "Load";
  Parts.Ground ground "Chassis";
initial equation
  der(inductor.i) = 0;
  der(capacitor.v) = 0;
equation
  connect(source.p, series.p);
  connect(series.n, inductor.p);
  connect(inductor.n, capacitor.p);
  connect(inductor.n, load.p);
  connect(capacitor.n, source.n);
  connect(load.n, source.n);
  connect(source.n, ground.p);
  i = inductor.i;
  v = capacitor.v;
end SteadyStart;

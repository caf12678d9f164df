within Small;
model Rectifier "An ideal diode charges a capacitor under load"
  input Parts.Voltage u(start=0) "Supply";
  output Parts.Voltage v "Voltage of the load";
  output Parts.Current i "Current of the diode";
  output Boolean blocking "True while the diode blocks";
  Parts.VoltageSource source(u=u) "Supply";
  Parts.Resistor source_R(R=1) "Resistance of the source";
  Parts.IdealDiode diode "Diode";
  Parts.Capacitor capacitor(C=0.01, v(start=0, fixed=true)) "Filter";
  Parts.Resistor load(R=10) "Load";
  Parts.Ground ground "Chassis";
equation
  connect(source.p, source_R.p);
  connect(source_R.n, diode.p);
  connect(diode.n, capacitor.p);
  connect(diode.n, load.p);
  connect(capacitor.n, source.n);
  connect(load.n, source.n);
  connect(source.n, ground.p);
  v = load.v;
  i = diode.i;
  blocking = diode.blocking;
end Rectifier;

within Small;
model Resonance "A series resonant circuit is driven at a frequency near its own"
  output Parts.Current i "Current";
  output Parts.Voltage v_C "Voltage of the capacitor";
  parameter Real w(unit="rad/s") = 100 "Angular frequency of the source";
  Parts.VoltageSource source(u=10*sin(w*time)) "Source";
  Parts.Resistor resistor(R=1) "Loss";
  Parts.Inductor inductor(L=0.1, i(start=0, fixed=true)) "Coil";
  Parts.Capacitor capacitor(C=1e-3, v(start=0, fixed=true)) "Capacitor";
  Parts.Ground ground "Chassis";
equation
  connect(source.p, resistor.p);
  connect(resistor.n, inductor.p);
  connect(inductor.n, capacitor.p);
  connect(capacitor.n, source.n);
  connect(source.n, ground.p);
  i = inductor.i;
  v_C = capacitor.v;
end Resonance;

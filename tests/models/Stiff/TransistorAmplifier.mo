within Stiff;
model TransistorAmplifier "Two stages with capacitive coupling, a DAE of index 1: P. Rentrop 1989; test set II-16, HW VI.1"
  output Parts.Voltage y[8] "Potentials of the nodes from the signal to the load";
  Parts.Ground ground "Chassis";
  Parts.Battery supply(E=6) "Supply";
  Parts.Signal signal(E=0.1, w=200*pi) "Signal to be amplified";
  Parts.Resistor r0(R=1000) "Resistance of the signal";
  Parts.Resistor r1 "Divider of the first stage";
  Parts.Resistor r2 "Divider of the first stage";
  Parts.Resistor r3 "Emitter of the first stage";
  Parts.Resistor r4 "Collector of the first stage";
  Parts.Resistor r5 "Divider of the second stage";
  Parts.Resistor r6 "Divider of the second stage";
  Parts.Resistor r7 "Emitter of the second stage";
  Parts.Resistor r8 "Collector of the second stage";
  Parts.Resistor r9 "Load";
  Parts.Capacitor c1(C=1e-6, v(start=-3, fixed=true)) "Input coupling";
  Parts.Capacitor c2(C=2e-6, v(start=3, fixed=true)) "Emitter of the first stage";
  Parts.Capacitor c3(C=3e-6, v(start=3, fixed=true)) "Coupling of the stages";
  Parts.Capacitor c4(C=4e-6, v(start=3, fixed=true)) "Emitter of the second stage";
  Parts.Capacitor c5(C=5e-6, v(start=6, fixed=true)) "Output coupling";
  Parts.Transistor t1 "First stage";
  Parts.Transistor t2 "Second stage";
protected
  constant Real pi(unit="rad/s") = 3.14159265358979323846 "Half a turn per second";
equation
  connect(ground.p, supply.n);
  connect(ground.p, signal.n);
  // signal
  connect(signal.p, r0.p);
  connect(r0.n, c1.p);
  // first stage
  connect(c1.n, t1.base);
  connect(r1.p, t1.base);
  connect(r1.n, ground.p);
  connect(r2.p, supply.p);
  connect(r2.n, t1.base);
  connect(t1.emitter, r3.p);
  connect(r3.n, ground.p);
  connect(t1.emitter, c2.p);
  connect(c2.n, ground.p);
  connect(r4.p, supply.p);
  connect(r4.n, t1.collector);
  // second stage
  connect(t1.collector, c3.p);
  connect(c3.n, t2.base);
  connect(r5.p, t2.base);
  connect(r5.n, ground.p);
  connect(r6.p, supply.p);
  connect(r6.n, t2.base);
  connect(t2.emitter, r7.p);
  connect(r7.n, ground.p);
  connect(t2.emitter, c4.p);
  connect(c4.n, ground.p);
  connect(r8.p, supply.p);
  connect(r8.n, t2.collector);
  // load
  connect(t2.collector, c5.p);
  connect(c5.n, r9.p);
  connect(r9.n, ground.p);
  y = {c1.p.v, t1.base.v, t1.emitter.v, t1.collector.v, t2.base.v, t2.emitter.v, t2.collector.v, r9.p.v};
end TransistorAmplifier;

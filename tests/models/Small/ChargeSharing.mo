within Small;
model ChargeSharing "A switch joins two charged capacitors"
  output Parts.Voltage v_1 "Voltage of the first capacitor";
  output Parts.Voltage v_2 "Voltage of the second capacitor";
  output Parts.Energy E "Energy in both";
  output Boolean closed "True while the switch is closed";
  parameter Parts.Time t_close = 0.1 "When the switch closes";
  Parts.Capacitor first(C=1e-3, v(start=10, fixed=true)) "First";
  Parts.Capacitor second(C=3e-3, v(start=2, fixed=true)) "Second";
  Parts.Resistor resistor(R=20) "Resistance of the leads";
  Parts.Switch switch "Switch";
  Parts.Ground ground "Chassis";
equation
  closed = time >= t_close;
  switch.closed = closed;
  connect(first.p, resistor.p);
  connect(resistor.n, switch.p);
  connect(switch.n, second.p);
  connect(first.n, second.n);
  connect(first.n, ground.p);
  v_1 = first.v;
  v_2 = second.v;
  E = first.C*v_1^2/2 + second.C*v_2^2/2;
end ChargeSharing;

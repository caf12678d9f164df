within Small;
model GearedInertias "Two inertias, rigidly coupled by a gear"
  input Parts.Torque tau(start=1) "Torque on the fast shaft";
  output Parts.AngularVelocity w_1 "Speed of the fast shaft";
  output Parts.AngularVelocity w_2 "Speed of the slow shaft";
  Parts.TorqueSource source(tau=tau) "Torque on the fast shaft";
  Parts.Inertia fast(J=0.01, phi(start=0, fixed=true), w(start=0, fixed=true)) "Fast shaft";
  Parts.Inertia slow(J=2) "Slow shaft";
  Parts.Gear gear(ratio=5) "Gear";
  Parts.SpringDamper friction(d=0.5) "Friction of the slow shaft";
  Parts.Fixed wall "Wall";
equation
  connect(source.flange, fast.a);
  connect(fast.b, gear.a);
  connect(gear.b, slow.a);
  connect(slow.b, friction.b);
  connect(friction.a, wall.flange);
  w_1 = fast.w;
  w_2 = slow.w;
end GearedInertias;

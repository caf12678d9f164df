within Small;
model MotorOnSpring "A DC motor that winds up a spring"
  input Parts.Voltage u(start=0) "Supply";
  output Parts.Angle phi(displayUnit="deg") "Angle of the rotor";
  output Parts.Current i "Current";
  parameter Parts.Resistance R = 2 "Resistance of the armature";
  parameter Parts.MomentOfInertia J = 2e-3 "Inertia of the rotor";
  Parts.VoltageSource source(u=u) "Supply";
  Parts.Resistor resistor(R=R) "Armature";
  Parts.Inductor inductor(L=0.1, i(start=0, fixed=true)) "Armature";
  Parts.EMF emf(k=0.3) "Conversion";
  Parts.Ground ground "Chassis";
  Parts.Inertia rotor(J=J, phi(start=0, fixed=true), w(start=0, fixed=true)) "Rotor";
  Parts.SpringDamper spring(c=0.5, d=0.01) "Spring to the wall";
  Parts.Fixed wall "Wall";
equation
  connect(source.p, resistor.p);
  connect(resistor.n, inductor.p);
  connect(inductor.n, emf.p);
  connect(emf.n, source.n);
  connect(emf.n, ground.p);
  connect(emf.flange, rotor.a);
  connect(rotor.b, spring.b);
  connect(spring.a, wall.flange);
  phi = rotor.phi;
  i = inductor.i;
end MotorOnSpring;

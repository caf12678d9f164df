within WiperDrive.Electrical;
model Motor "Permanent-magnet DC motor with a filter inductor on either side"
  parameter Types.Resistance R = 1.91 "Armature resistance [S] table 3.4";
  parameter Types.Inductance L = 3.75e-3 "Armature inductance [S] table 3.4";
  parameter Types.Inductance L_filter = 5.7e-6 "Filter inductance, each of two [S] table 3.4";
  parameter Types.MotorConstant k = 0.113 "Torque and back-EMF constant [S] table 3.4";
  parameter Types.Current i_no_load = 0.58 "No-load current [S] table 3.4";
  parameter Types.Voltage v_no_load = 28 "Supply voltage of the no-load current [S] table 3.4";
  parameter Types.MomentOfInertia J = 1.0e-4 "Rotor inertia [A] usual for a 70 W wiper motor for 24 V";
  final parameter Types.RotationalDamping d = k^2*i_no_load/(v_no_load - R*i_no_load)
    "Rotor damping [S] table 3.4: the no-load torque over the no-load speed, as Simscape derives it";
  Interfaces.Pin p "Supply side";
  Interfaces.Pin n "Return side";
  Interfaces.Flange flange "Rotor shaft";
  Inductor filter_supply(L=L_filter) "Filter inductor on the supply side";
  Inductor filter_return(L=L_filter) "Filter inductor on the return side";
  Resistor resistor(R=R) "Armature resistance";
  Inductor inductor(L=L) "Armature inductance";
  EMF emf(k=k) "Conversion of power";
  Rotational.Inertia rotor(J=J) "Rotor";
  Rotational.Damper friction(d=d) "No-load friction";
  Types.Energy E_magnetic "Energy of the magnetic fields";
equation
  connect(p, filter_supply.p);
  connect(filter_supply.n, resistor.p);
  connect(resistor.n, inductor.p);
  connect(inductor.n, emf.p);
  connect(emf.n, filter_return.p);
  connect(filter_return.n, n);
  connect(emf.flange, rotor.flange_a);
  connect(rotor.flange_a, friction.flange);
  connect(rotor.flange_b, flange);
  E_magnetic = filter_supply.E_magnetic + inductor.E_magnetic + filter_return.E_magnetic;
end Motor;

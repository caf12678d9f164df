within Small;
package Parts "Connectors and components of the small models"
  type Voltage = Real(unit="V", quantity="ElectricPotential") "Voltage";
  type Current = Real(unit="A", quantity="ElectricCurrent") "Current";
  type Resistance = Real(unit="Ohm", min=0) "Resistance";
  type Inductance = Real(unit="H", min=0) "Inductance";
  type Capacitance = Real(unit="F", min=0) "Capacitance";
  type Angle = Real(unit="rad", quantity="Angle", displayUnit="deg") "Angle";
  type AngularVelocity = Real(unit="rad/s") "Angular velocity";
  type Torque = Real(unit="N.m") "Torque";
  type MomentOfInertia = Real(unit="kg.m2", min=0) "Moment of inertia";
  type Length = Real(unit="m") "Length";
  type Velocity = Real(unit="m/s") "Velocity";
  type Acceleration = Real(unit="m/s2") "Acceleration";
  type Mass = Real(unit="kg", min=0) "Mass";
  type Force = Real(unit="N") "Force";
  type Energy = Real(unit="J") "Energy";
  type Time = Real(unit="s") "Time";

  connector Pin "Electrical pin"
    Voltage v "Potential";
    flow Current i "Current into the component";
  end Pin;

  partial model TwoPin "Component with two pins"
    Pin p "Positive pin";
    Pin n "Negative pin";
    Voltage v "Voltage from p to n";
    Current i "Current from p to n";
  equation
    v = p.v - n.v;
    i = p.i;
    // conservation of charge
    0 = p.i + n.i;
  end TwoPin;

  model Ground "Potential zero"
    Pin p "Pin";
  equation
    p.v = 0;
  end Ground;

  model Resistor "Ohm's law"
    extends TwoPin;
    parameter Resistance R "Resistance";
  equation
    v = R*i;
  end Resistor;

  model Inductor "Ideal inductor"
    extends TwoPin;
    parameter Inductance L "Inductance";
  equation
    L*der(i) = v;
  end Inductor;

  model Capacitor "Ideal capacitor"
    extends TwoPin;
    parameter Capacitance C "Capacitance";
  equation
    C*der(v) = i;
  end Capacitor;

  model VoltageSource "Voltage given from outside"
    extends TwoPin;
    input Voltage u "Voltage";
  equation
    v = u;
  end VoltageSource;

  model IdealDiode "Diode without loss: either no current or no voltage, the characteristic in a parameter s"
    extends TwoPin;
    Boolean blocking "True while the voltage is negative";
    Real s(unit="1") "Voltage in V while blocking, current in A while conducting";
    constant Voltage one_volt = 1 "Unit of s while blocking";
    constant Current one_ampere = 1 "Unit of s while conducting";
  equation
    blocking = s < 0;
    v = if blocking then s*one_volt else 0;
    i = if blocking then 0 else s*one_ampere;
  end IdealDiode;

  model Switch "Ideal switch: either no voltage or no current"
    extends TwoPin;
    Boolean closed "True while closed";
  equation
    0 = if closed then v*one_ampere else i*one_volt;
  protected
    constant Voltage one_volt = 1 "Unit of the voltage";
    constant Current one_ampere = 1 "Unit of the current";
  end Switch;

  connector Flange "Shaft end"
    Angle phi "Angle";
    flow Torque tau "Torque into the component";
  end Flange;

  model Inertia "Newton's law of a rotor"
    Flange a "Left end";
    Flange b "Right end";
    parameter MomentOfInertia J "Moment of inertia";
    Angle phi "Angle";
    AngularVelocity w "Speed";
  equation
    phi = a.phi;
    phi = b.phi;
    w = der(phi);
    J*der(w) = a.tau + b.tau;
  end Inertia;

  model SpringDamper "Hooke's law, and friction proportional to the speed"
    Flange a "Left end";
    Flange b "Right end";
    parameter Real c(unit="N.m/rad") = 0 "Stiffness";
    parameter Real d(unit="N.m.s/rad") = 0 "Damping";
    Angle phi_rel "Angle of b against a";
    Torque tau "Torque at b";
  equation
    phi_rel = b.phi - a.phi;
    tau = c*phi_rel + d*der(phi_rel);
    b.tau = tau;
    a.tau = -tau;
  end SpringDamper;

  model Fixed "Wall"
    Flange flange "Shaft end";
  equation
    flange.phi = 0;
  end Fixed;

  model TorqueSource "Torque given from outside"
    Flange flange "Shaft end";
    input Torque tau "Torque on what is connected";
  equation
    flange.tau = -tau;
  end TorqueSource;

  model Gear "Ideal gear"
    Flange a "Fast shaft";
    Flange b "Slow shaft";
    parameter Real ratio(unit="1") "Turns of a for one turn of b";
  equation
    a.phi = ratio*b.phi;
    // power balance
    0 = ratio*a.tau + b.tau;
  end Gear;

  model EMF "Electromechanical conversion"
    extends TwoPin;
    Flange flange "Shaft end";
    parameter Real k(unit="N.m/A") "Motor constant";
  equation
    v = k*der(flange.phi);
    flange.tau = -k*i;
  end EMF;
end Parts;

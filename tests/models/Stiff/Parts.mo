within Stiff;
package Parts "Types and the components of the amplifier"
  type Voltage = Real(unit="V", quantity="ElectricPotential") "Voltage";
  type Current = Real(unit="A", quantity="ElectricCurrent") "Current";
  type Resistance = Real(unit="Ohm", min=0) "Resistance";
  type Inductance = Real(unit="H", min=0) "Inductance";
  type Capacitance = Real(unit="F", min=0) "Capacitance";
  type Amount = Real(unit="1") "Scaled concentration";
  type Rate = Real(unit="1/s") "Rate constant of a reaction, concentrations scaled";

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
    parameter Resistance R = 9000 "Resistance";
  equation
    v = R*i;
  end Resistor;

  model Capacitor "Ideal capacitor"
    extends TwoPin;
    parameter Capacitance C "Capacitance";
  equation
    C*der(v) = i;
  end Capacitor;

  model Battery "Constant voltage"
    extends TwoPin;
    parameter Voltage E "Voltage";
  equation
    v = E;
  end Battery;

  model Signal "Sinusoidal voltage"
    extends TwoPin;
    parameter Voltage E "Amplitude";
    parameter Real w(unit="rad/s") "Angular frequency";
  equation
    v = E*sin(w*time);
  end Signal;

  model Transistor "Transistor whose emitter current is that of an exponential diode"
    Pin base "Base";
    Pin collector "Collector";
    Pin emitter "Emitter";
    parameter Current I_s = 1e-6 "Saturation current";
    parameter Voltage U_F = 0.026 "Thermal voltage";
    parameter Real alpha(unit="1") = 0.99 "Share of the emitter current that the collector takes";
    Current i_diode "Current out of the emitter";
  equation
    i_diode = I_s*(exp((base.v - emitter.v)/U_F) - 1);
    emitter.i = -i_diode;
    collector.i = alpha*i_diode;
    base.i = (1 - alpha)*i_diode;
  end Transistor;
end Parts;

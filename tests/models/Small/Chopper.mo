within Small;
model Chopper "Two clocks switch a coil on and off: pulse width modulation with a freewheeling diode"
  output Parts.Current i(start=0, fixed=true) "Current";
  output Boolean on "True while the switch is closed";
  Integer closed(start=0, fixed=true) "How often it has been closed";
  Integer opened(start=0, fixed=true) "How often it has been opened";
  parameter Parts.Voltage U = 24 "Supply";
  parameter Parts.Resistance R = 2 "Resistance";
  parameter Parts.Inductance L = 0.01 "Inductance";
  parameter Parts.Time period = 1e-3 "Period of the modulation";
  parameter Real duty(unit="1") = 0.3 "Part of the period in which the switch is closed";
equation
  // the diode carries the current on while the switch is open
  L*der(i) = (if on then U else 0) - R*i;
  on = opened < closed;
  when sample(0, period) then
    closed = pre(closed) + 1;
  end when;
  when sample(duty*period, period) then
    opened = pre(opened) + 1;
  end when;
end Chopper;

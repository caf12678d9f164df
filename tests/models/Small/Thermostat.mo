within Small;
model Thermostat "A heater that a thermostat switches between two temperatures"
  output Real T(unit="K", start=290, fixed=true) "Temperature of the room";
  output Boolean heating(start=true, fixed=true) "True while the heater is on";
  output Integer switchings(start=0, fixed=true) "How often it has been switched";
  output Parts.Energy E(start=0, fixed=true) "Heat delivered";
  parameter Real T_low(unit="K") = 293 "Temperature at which it starts";
  parameter Real T_high(unit="K") = 295 "Temperature at which it stops";
  parameter Real T_out(unit="K") = 273 "Temperature outside";
  parameter Real C(unit="J/K") = 5e5 "Heat capacity of the room";
  parameter Real G(unit="W/K") = 100 "Heat conductance of the walls";
  parameter Real P(unit="W") = 4000 "Power of the heater";
  Real Q(unit="W") "Heat of the heater";
equation
  Q = if heating then P else 0;
  // balance of energy
  C*der(T) = Q - G*(T - T_out);
  der(E) = Q;
algorithm
  when T > T_high then
    heating := false;
    switchings := pre(switchings) + 1;
  elsewhen T < T_low then
    heating := true;
    switchings := pre(switchings) + 1;
  end when;
end Thermostat;

within WiperDrive.Electrical;
partial model Bridge "H-bridge in one-quadrant mode with ideal freewheel diode; how it is switched is left open"
  parameter Types.Current i_max = 1000 "Current to which the bridge limits itself [A] off; [S] 4.2: supply 10 A, bridge 15 A";
  parameter Boolean short_brake = false
    "True: at duty ratio zero the load is shorted to brake [A] off; the production motor does so when it parks";
  input Types.Ratio duty "Duty ratio, 0..1";
  input Types.Voltage v_supply "Supply voltage";
  constant Types.Inductance L_1 = 1 "Gives both branches of the bridge's law the same unit";
  constant Types.Voltage V_1 = 1 "Scale of the bridge's characteristic";
  constant Types.Current I_1 = 1 "Scale of the bridge's characteristic";
  constant Types.Ratio rounding = 1e-9 "What rounding errors may make of a current of zero";
  constant Types.Voltage v_threshold = 1e-3 "Voltage at which diode and limit let go, far below a real diode's";
  Interfaces.Pin p "Output to the load";
  Interfaces.Pin n "Return from the load";
  Types.Ratio share "Share of the supply that is switched to the load at this instant";
  Types.Voltage v "Voltage across the load";
  Types.Current i(start=0, fixed=true, stateSelect=StateSelect.always) "Current through the load";
  Types.Current i_switch "Current in the switch, where it is measured: never negative";
  Types.Power P_supply "Power taken from the supply";
  Types.Ratio s_diode "Place on the diode's characteristic of current over voltage";
  Types.Ratio s_limit "Place on the limiter's characteristic of current over voltage";
  Boolean blocking(start=true, fixed=true) "True while the diode blocks and no current flows";
  Boolean limiting(start=false, fixed=true) "True while the current is held at its limit";
  Boolean returning(start=false, fixed=true) "True while a reversed current returns to the supply";
  Boolean braking(start=false, fixed=true) "True while the load is shorted and its current may reverse";
equation
  v = p.v - n.v;
  i = -p.i;
  // conservation of charge
  0 = p.i + n.i;
  // While current flows, the output is the switched share of the supply: the polarity is fixed and the freewheel diode
  // carries the current in the off time. While the diode blocks or the limit holds, the current is
  // constant and the load sets the voltage. Either branch holds the current or its derivative through the voltage, so
  // the structure is the same in all modes.
  0 = if blocking or limiting then L_1*der(i) else v - (if returning then v_supply else share*v_supply);
  braking = short_brake and duty <= 0;
  // Diode and limit are each a characteristic with one corner, through which its parameter passes steadily: on the one
  // side it is the current beyond the corner, on the other the drive's voltage beyond the load's.
  // Small thresholds keep a current that only touches its corner from having no side at all.
  // What current has reversed while braking then returns to the supply, before the diode can block.
  s_diode = if blocking then (share*v_supply - v - v_threshold)/V_1 else i/I_1 + rounding;
  returning = s_diode < 0 and not braking and (pre(returning) or pre(braking));
  blocking = s_diode < 0 and not braking and not returning;
  s_limit = if limiting then (share*v_supply - v + v_threshold)/V_1 else (i - i_max)/I_1 - rounding;
  limiting = s_limit > 0;
  // An event is found a little after the current has passed its bound.
  when blocking then
    reinit(i, 0);
  elsewhen limiting then
    reinit(i, i_max);
  end when;
  i_switch = noEvent(max(i, 0));
  P_supply = v*i;
end Bridge;

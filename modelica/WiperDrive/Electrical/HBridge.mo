within WiperDrive.Electrical;
model HBridge "Averaged H-bridge in one-quadrant mode with ideal freewheel diode"
  input Types.Ratio duty "Duty ratio, 0..1";
  input Types.Voltage v_supply "Supply voltage";
  constant Types.Inductance L_1 = 1 "Gives both branches of the bridge's law the same unit";
  constant Types.Voltage V_1 = 1 "Scale of the diode's characteristic";
  constant Types.Current I_1 = 1 "Scale of the diode's characteristic";
  Interfaces.Pin p "Output to the load";
  Interfaces.Pin n "Return from the load";
  Types.Voltage v "Voltage across the load";
  Types.Current i(start=0, fixed=true, stateSelect=StateSelect.always) "Current through the load, never negative";
  Types.Power P_supply "Power taken from the supply";
  Types.Ratio s "Place on the ideal diode's characteristic: the current, negative, or the voltage in excess while it blocks";
  Boolean blocking(start=true, fixed=true) "True while the diode blocks and no current flows";
equation
  v = p.v - n.v;
  i = -p.i;
  // conservation of charge
  0 = p.i + n.i;
  // While current flows, the average output is the switched share of the supply: the polarity is fixed and the
  // freewheel diode carries the current in the off time. While the diode blocks, the current stays zero and the
  // load sets the voltage. Both branches bind the current's derivative, so the structure is the same in both modes.
  0 = if blocking then L_1*der(i) else v - duty*v_supply;
  // The characteristic has a corner, but s passes through it steadily: the diode blocks from where the current would
  // turn negative, and conducts again from where the drive exceeds the voltage of the load.
  s = if blocking then (v - duty*v_supply)/V_1 else -i/I_1;
  blocking = s > 0;
  // The event is found a little after the current has crossed zero.
  when blocking then
    reinit(i, 0);
  end when;
  P_supply = v*i;
end HBridge;

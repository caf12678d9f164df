within WiperDrive.Controllers;
block ConstantVoltage "Open loop of today's production, section 2.4.1: constant voltage, switched off at the park contact"
  extends Controller;
  parameter Types.Time T_compute = 0.001 "Period at which the inputs are read [A] as the voltage profile's";
  parameter Types.Ratio duty_run = 1 "Duty ratio while the wiper runs [S] 2.4.1: a switch, so the whole supply";
  output Types.ChartState state(start=Types.ChartState.IDLE, fixed=true) "IDLE or RUN";
protected
  discrete Boolean closed(start=true, fixed=true) "State of the park contact";
equation
  when sample(0, T_compute) then
    closed = park;
    // Once enable has fallen the wiper runs on until the contact closes, and coasts from there.
    state = if enable then Types.ChartState.RUN
      elseif park and not pre(closed) then Types.ChartState.IDLE
      else pre(state);
    duty = if state == Types.ChartState.RUN then duty_run else 0;
  end when;
end ConstantVoltage;

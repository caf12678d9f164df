within WiperDrive.Electronics;
block PowerOutput "From the algorithm's duty ratio to the bridge's: steps of the timer, protection that latches off"
  input Types.Ratio duty_wanted(start=0) "Duty ratio that the algorithm asks for";
  input Types.Current i(start=0) "Current that the protection sees";
  input Boolean enable(start=true) "True while the wiper is to run; its fall releases the protection";
  parameter Types.Time T_compute = 0.001 "Period at which the duty ratio is set [A] as the chart's";
  parameter Integer n_pwm = 0 "Steps of the timer from 0 to 1, 0: off [A] the source gives none";
  parameter Types.Current i_trip = 0 "Current above which the bridge latches off, 0: off [S] 4.2.2: 15 A";
  output Types.Ratio duty(start=0, fixed=true) "Duty ratio of the bridge";
  output Boolean tripped(start=false, fixed=true) "True once the protection has latched off";
equation
  assert(n_pwm >= 0, "n_pwm must not be negative.");
  when {sample(0, T_compute), i_trip > 0 and i > i_trip} then
    tripped = enable and (pre(tripped) or (i_trip > 0 and i > i_trip));
    duty = if tripped then 0 elseif n_pwm > 0 then floor(duty_wanted*n_pwm + 0.5)/n_pwm else duty_wanted;
  end when;
end PowerOutput;

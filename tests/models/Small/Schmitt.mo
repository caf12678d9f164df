within Small;
model Schmitt "A switch with hysteresis and an RC lag make an oscillator"
  output Parts.Voltage v(start=0, fixed=true) "Voltage of the capacitor";
  output Boolean high(start=true, fixed=true) "Output of the trigger";
  output Integer periods(start=0, fixed=true) "Periods so far";
  output Parts.Time last(start=0, fixed=true) "When the last period began";
  parameter Parts.Time tau = 0.1 "Time constant";
  parameter Parts.Voltage U = 5 "Output voltage, positive or negative";
  parameter Real k(unit="1") = 0.4 "Part of the output at which the trigger turns over";
equation
  tau*der(v) = (if high then U else -U) - v;
  high = if pre(high) then v < k*U else v < -k*U;
  when high then
    periods = pre(periods) + 1;
    last = time;
  end when;
end Schmitt;

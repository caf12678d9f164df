within Small;
model Counter "Counts the rising edges and all changes of a comparator on a sine"
  output Integer rising(start=0, fixed=true) "Rising edges so far";
  output Integer changes(start=0, fixed=true) "Changes so far";
  output Integer digit(start=0, fixed=true) "Rising edges modulo 4";
  output Parts.Time last(start=0, fixed=true) "Time of the last rising edge";
  output Boolean high(start=false, fixed=true) "True while the sine is above the level";
  parameter Real w(unit="rad/s") = 5 "Angular frequency";
  parameter Real level(unit="1") = 0.5 "Level of the comparator";
equation
  high = sin(w*time) > level;
  when high then
    rising = pre(rising) + 1;
    digit = if pre(digit) == 3 then 0 else pre(digit) + 1;
    last = time;
  end when;
  when change(high) then
    changes = pre(changes) + 1;
  end when;
end Counter;

within Small;
model Tank "A tank that a switch with hysteresis keeps between two levels"
  output Parts.Length level(start=0.5, fixed=true) "Level";
  output Boolean filling(start=true, fixed=true) "True while the pump runs";
  output Integer starts(start=0, fixed=true) "How often the pump has started";
  parameter Parts.Length low = 0.4 "Level at which the pump starts";
  parameter Parts.Length high = 1 "Level at which the pump stops";
  parameter Parts.Velocity q_in = 0.3 "Rise by the pump";
  parameter Real k(unit="1/s") = 0.2 "Outflow for each metre of level";
equation
  der(level) = (if filling then q_in else 0) - k*level;
  filling = if pre(filling) then level < high else level < low;
  when filling then
    starts = pre(starts) + 1;
  end when;
end Tank;

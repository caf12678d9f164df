within Small;
model RestingBall "A ball that bounces until it is slow, and then rests"
  constant Parts.Acceleration g = 9.81 "Gravity";
  parameter Real restitution(unit="1") = 0.6 "Part of the speed that is left after a bounce";
  parameter Parts.Velocity v_rest = 0.05 "Speed after a bounce below which the ball stays down";
  output Parts.Length h(start=1, fixed=true) "Height";
  output Parts.Velocity v(start=0, fixed=true) "Speed";
  output Boolean resting(start=false, fixed=true) "True from when the ball stays down";
  output Integer bounces(start=0, fixed=true) "Bounces so far";
  output Parts.Time t_rest(start=0, fixed=true) "When it came to rest";
equation
  der(h) = v;
  der(v) = if resting then 0 else -g;
  when h < 0 and not pre(resting) then
    bounces = pre(bounces) + 1;
    resting = -restitution*v < v_rest;
    t_rest = time;
    reinit(v, if resting then 0 else -restitution*v);
    reinit(h, 0);
  end when;
end RestingBall;

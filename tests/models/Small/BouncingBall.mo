within Small;
model BouncingBall "A ball that loses a fixed share of its speed at each bounce"
  constant Parts.Acceleration g = 9.81 "Gravity";
  parameter Real e(unit="1") = 0.7 "Coefficient of restitution";
  parameter Parts.Length h_0 = 1 "Height at the start";
  output Parts.Length h(start=h_0, fixed=true) "Height";
  output Parts.Velocity v(start=0, fixed=true) "Speed, upwards";
  output Integer bounces(start=0, fixed=true) "Bounces so far";
  output Parts.Time last_bounce(start=0, fixed=true) "Time of the last bounce";
equation
  der(h) = v;
  der(v) = -g;
  when h <= 0 then
    reinit(v, -e*pre(v));
    bounces = pre(bounces) + 1;
    last_bounce = time;
  end when;
end BouncingBall;

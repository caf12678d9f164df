within Small;
model SendOnDelta "A sensor sends a sine whenever it has moved by a fixed amount since it last did"
  output Parts.Angle x(start=0, fixed=true) "Angle";
  output Parts.Angle sent(start=0, fixed=true) "What was sent last";
  output Parts.Time last(start=0, fixed=true) "When it was sent";
  output Integer messages(start=0, fixed=true) "How often it was sent";
  parameter Parts.Angle delta = 0.3 "Movement at which it is sent";
  parameter Parts.Angle amplitude = 1 "Amplitude";
  parameter Parts.AngularVelocity w = 1 "Angular frequency";
equation
  der(x) = amplitude*w*cos(w*time);
  when abs(x - pre(sent)) > delta then
    sent = x;
    last = time;
    messages = pre(messages) + 1;
  end when;
end SendOnDelta;

within Small;
model Steps "floor, ceil and mod make events"
  output Parts.Angle phi(start=0, fixed=true) "Ramp";
  output Real saw(unit="rad") "The ramp modulo its period";
  output Integer turns "Whole periods";
  output Integer rounded_up "Started periods";
  output Real area(start=0, fixed=true) "Integral of the saw-tooth";
  parameter Parts.Angle period = 0.7 "Period";
  parameter Parts.AngularVelocity w = 1 "Rate";
equation
  der(phi) = w;
  saw = mod(phi, period);
  turns = integer(floor(phi/period));
  rounded_up = integer(ceil(phi/period));
  der(area) = saw;
end Steps;

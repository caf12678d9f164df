within Split;
model TwoBodies "Both bodies in one"
  output Types.Temperature T1 "Temperature of the heated body";
  output Types.Temperature T2 "Temperature of the other";
  output Types.Power q "Heat that goes over";
  HeatedBody heated(q=q) "Source";
  RadiatingBody radiating(T1=T1) "Sink";
equation
  T1 = heated.T;
  T2 = radiating.T;
  q = radiating.q;
end TwoBodies;

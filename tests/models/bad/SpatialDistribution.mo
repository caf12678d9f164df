model SpatialDistribution "Transport along a belt"
  Real a(unit="1") "Leaves at the start";
  Real b(unit="1") "Leaves at the end";
equation
  (a, b) = spatialDistribution(time, 0, time, true);
end SpatialDistribution;

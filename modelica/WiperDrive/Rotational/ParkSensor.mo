within WiperDrive.Rotational;
model ParkSensor "Contact on the output gear, closed once per revolution"
  parameter Types.Angle width = 2*Constants.pi/180 "Angle over which the contact is closed [S] 3.2.1: about 2 deg";
  Interfaces.Flange flange "Output shaft";
  Boolean on "True on the contact; electrically the contact is active low";
equation
  // The contact opens at the angle `width`; the start position is on it.
  on = mod(flange.phi, 2*Constants.pi) < width;
  flange.tau = 0;
end ParkSensor;

within WiperDrive.Planar;
model Fixed "Point fixed to the ground"
  parameter Types.Length x = 0 "x position [A] set by the model that uses it";
  parameter Types.Length y = 0 "y position [A] set by the model that uses it";
  Interfaces.Frame frame "Ground";
equation
  frame.x = x;
  frame.y = y;
  frame.phi = 0;
end Fixed;

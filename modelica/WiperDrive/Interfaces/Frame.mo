within WiperDrive.Interfaces;
connector Frame "Frame of a body in the plane"
  Types.Length x "x position";
  Types.Length y "y position";
  Types.Angle phi "Orientation, counter-clockwise from the x axis";
  flow Types.Force fx "Force in x into the component";
  flow Types.Force fy "Force in y into the component";
  flow Types.Torque t "Torque into the component";
end Frame;

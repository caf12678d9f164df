within WiperDrive.Interfaces;
connector Flange "Rotational flange"
  Types.Angle phi "Absolute angle";
  flow Types.Torque tau "Torque into the component";
end Flange;

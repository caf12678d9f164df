within WiperDrive.Electrical;
model Ground "Chassis ground"
  Interfaces.Pin p "Pin on ground potential";
equation
  p.v = 0;
end Ground;

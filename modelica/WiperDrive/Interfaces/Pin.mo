within WiperDrive.Interfaces;
connector Pin "Electrical pin"
  Types.Voltage v "Potential";
  flow Types.Current i "Current into the component";
end Pin;

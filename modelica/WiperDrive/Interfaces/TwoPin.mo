within WiperDrive.Interfaces;
partial model TwoPin "Component with two pins and one current"
  Pin p "Positive pin";
  Pin n "Negative pin";
  Types.Voltage v "Voltage from p to n";
  Types.Current i "Current from p to n";
equation
  v = p.v - n.v;
  i = p.i;
  // conservation of charge
  0 = p.i + n.i;
end TwoPin;

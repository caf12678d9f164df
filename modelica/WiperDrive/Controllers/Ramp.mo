within WiperDrive.Controllers;
partial function Ramp "Shape of a ramp: rises from 0 to 1 with its argument"
  input Types.Ratio x "Part of the ramp's duration that has passed, 0..1";
  output Types.Ratio y "Part of the ramp's height that has been reached";
end Ramp;

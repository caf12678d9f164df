within WiperDrive.Controllers;
partial block Controller "Interface of a controller of the drive"
  input Types.Current i_motor(start=0) "Motor current";
  input Boolean park(start=true) "True on the park contact";
  input Boolean enable(start=true) "True while the wiper is to run";
  output Types.Ratio duty(start=0, fixed=true) "Duty ratio for the bridge, 0..1";
end Controller;

within WiperDrive.Controllers;
function LinearRamp "Straight line: the trapezoid of figure 3.12"
  extends Ramp;
algorithm
  y := x;
end LinearRamp;

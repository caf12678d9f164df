within WiperDrive.Controllers;
function SRamp "Two parabolas: the rate changes steadily, by four times the ramp's height over its duration squared"
  extends Ramp;
algorithm
  y := if x < 0.5 then 2*x^2 else 1 - 2*(1 - x)^2;
end SRamp;

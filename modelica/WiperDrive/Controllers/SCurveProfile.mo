within WiperDrive.Controllers;
block SCurveProfile "The source's chart with jerk-limited ramps in place of the trapezoid's, as section 3.5.1 suggests"
  extends Profile(redeclare function ramp = SRamp);
end SCurveProfile;

within WiperDrive.Electrical;
model HBridge "Averaged H-bridge in one-quadrant mode with ideal freewheel diode"
  extends Bridge;
equation
  // the mean over a period of the switching, right in continuous conduction
  share = duty;
end HBridge;

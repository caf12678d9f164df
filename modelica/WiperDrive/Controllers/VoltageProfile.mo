within WiperDrive.Controllers;
block VoltageProfile "The source's current-controlled voltage profile, section 3.5: a trapezoid"
  extends Profile;
end VoltageProfile;

within WiperDrive.Systems;
model SwitchedRigPlant "Lifetime-test rig of chapter 4 with a bridge that switches: the ripple of figure 4.8"
  extends RigPlant(redeclare model BridgeModel = Electrical.SwitchedBridge);
end SwitchedRigPlant;

within WiperDrive.Tests;
model BridgeRunOut "The supply is switched off and on again: the current ends at zero, the rotor coasts on friction alone"
  Electrical.HBridge bridge(duty=if time < 0.1 then 1 elseif time < 0.2 then 0 else 1, v_supply=28) "Bridge";
  Electrical.Ground ground "Chassis";
  Electrical.Motor motor(rotor(phi(start=0, fixed=true), w(start=0, fixed=true))) "Motor without gear";
equation
  connect(bridge.p, motor.p);
  connect(bridge.n, motor.n);
  connect(bridge.n, ground.p);
end BridgeRunOut;

within WiperDrive.Tests;
model BridgeLimit "A limit of the current holds it while the motor speeds up, and lets go in time"
  Electrical.HBridge bridge(i_max=5, duty=1, v_supply=28) "Bridge";
  Electrical.Ground ground "Chassis";
  Electrical.Motor motor(rotor(phi(start=0, fixed=true), w(start=0, fixed=true))) "Motor without gear";
equation
  connect(bridge.p, motor.p);
  connect(bridge.n, motor.n);
  connect(bridge.n, ground.p);
end BridgeLimit;

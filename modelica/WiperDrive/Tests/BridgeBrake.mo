within WiperDrive.Tests;
model BridgeBrake "The bridge shorts the motor at duty ratio zero, then drives it again"
  Electrical.HBridge bridge(short_brake=true, duty=if time < 0.1 then 1 elseif time < 0.2 then 0 else 1, v_supply=28)
    "Bridge";
  Electrical.Ground ground "Chassis";
  Electrical.Motor motor(rotor(phi(start=0, fixed=true), w(start=0, fixed=true))) "Motor without gear";
equation
  connect(bridge.p, motor.p);
  connect(bridge.n, motor.n);
  connect(bridge.n, ground.p);
end BridgeBrake;

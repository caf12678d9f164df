within WiperDrive.Tests;
model SenseChain "A motor starts, stalls the amplifier, and its current is measured by the circuit and sample by sample"
  parameter Types.Time T_measure = 0.001 "Period of measuring [A] any";
  parameter Types.Ratio gain_error = 0.02 "Relative error of the gain [A] any";
  parameter Types.Voltage v_offset = 0.03 "Offset of the amplifier [A] any";
  Electrical.HBridge bridge(duty=1, v_supply=28) "Bridge";
  Electrical.Motor motor(rotor(phi(start=0, fixed=true), w(start=0, fixed=true))) "Motor without gear";
  Electrical.Ground ground "Chassis";
  Electronics.SenseCircuit circuit(gain_error=gain_error, v_offset=v_offset) "Circuit in the return path";
  Electronics.CurrentInput input_(T_measure=T_measure, amplifier=true, gain_error=gain_error, v_offset=v_offset,
    f_lowpass=50, i_motor=bridge.i) "The same, sample by sample";
equation
  connect(bridge.p, motor.p);
  connect(motor.n, circuit.p);
  connect(circuit.n, bridge.n);
  connect(bridge.n, ground.p);
end SenseChain;

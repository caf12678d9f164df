within WiperDrive.Electrical;
model SwitchedBridge "H-bridge that switches the supply on and off, as the pulses of its modulator say"
  extends Bridge;
  parameter Types.Frequency f_pwm = 1e5 "Frequency of the pulses [S] 4.4.1: 100 kHz; figure 4.8 has 1 kHz and 10 Hz, too";
  PulseWidthModulator modulator(f=f_pwm, duty=duty) "Modulator";
equation
  share = if modulator.on then 1 else 0;
end SwitchedBridge;

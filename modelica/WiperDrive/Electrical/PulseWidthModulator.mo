within WiperDrive.Electrical;
block PulseWidthModulator "Pulses from the beginning of each period, of a length that is fixed there"
  parameter Types.Frequency f = 1e5 "Frequency [S] 4.4.1: 100 kHz";
  input Types.Ratio duty "Duty ratio, 0..1";
  output Boolean on "True during a pulse";
  discrete Types.Time t_off(start=0, fixed=true) "End of the pulse";
equation
  // regular sampling at the leading edge: a change of the duty ratio waits for the next period, and both edges are
  // known beforehand
  when sample(0, 1/f) then
    t_off = time + duty/f;
  end when;
  on = time < t_off;
end PulseWidthModulator;

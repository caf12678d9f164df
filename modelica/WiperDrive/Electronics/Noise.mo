within WiperDrive.Electronics;
block Noise "Seeded random numbers, new ones each period; the same for one seed on every machine"
  parameter Types.Time T = 0.001 "Period [A] set by the block that uses it";
  parameter Integer seed = 1 "Begin of the sequence, from 0 on [A] any";
  output Types.Ratio normal(start=0, fixed=true) "Mean 0, variance 1, bell-shaped, between -6 and 6";
  output Types.Ratio uniform(start=0, fixed=true) "Evenly distributed between 0 and 1, independent of `normal`";
protected
  discrete Types.Ratio state[2](start=seeds(seed), each fixed=true) "State of the generator";
  discrete Types.Ratio r[15](each start=0, each fixed=true) "Numbers of this period, and the state after them";
equation
  assert(seed >= 0, "seed must not be negative.");
  when sample(0, T) then
    r = draw(pre(state));
    state = r[14:15];
    // The sum of twelve has variance 12/12. It takes additions only, which round alike everywhere; log() and cos() need not.
    normal = sum(r[1:12]) - 6;
    uniform = r[13];
  end when;
end Noise;

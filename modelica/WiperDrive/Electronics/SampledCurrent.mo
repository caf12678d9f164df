within WiperDrive.Electronics;
block SampledCurrent "From the motor current to a number, without what happens between samples: noise, moving average"
  input Types.Current i_motor(start=0) "Motor current";
  parameter Types.Time T_measure = 0.001 "Period of measuring [A] as T_compute; the source left other rates out (chapter 5)";
  parameter Integer seed = 1 "Seed of the noise [A] any";
  parameter Types.Current i_noise = 0 "Standard deviation of a sample's noise [A] off: the source gives none";
  parameter Types.Time T_filter = 0 "Length of the moving average, 0: off [S] 4.3: 0.125 s on the rig";
  final parameter Integer n_filter = max(1, integer(floor(T_filter/T_measure + 0.5)))
    "Samples in the moving average [A] T_filter to the nearest sample, at least one";
  output Types.Current i(start=0, fixed=true) "Moving average of the samples";
protected
  constant Integer N_filter = 1024 "Capacity of the moving average, also the literal in `enter`";
  parameter Types.Ratio enter[N_filter] = {if k == n_filter then 1.0 else 0.0 for k in 1:1024}
    "Place at which a sample enters the moving average [A] follows from n_filter";
  Noise noise(T=T_measure, seed=seed) "Random numbers of this sample";
  discrete Types.Current i_sample(start=0, fixed=true) "Last sample";
  discrete Types.Current samples[N_filter](each start=0, each fixed=true) "Moving average, next to leave first";
  discrete Types.Current total(start=0, fixed=true) "Sum of the samples in the moving average";
equation
  assert(n_filter <= N_filter, "T_filter must not exceed 1024 periods of T_measure.");
  assert(i_noise >= 0, "i_noise must not be negative.");
  when sample(0, T_measure) then
    i_sample = if i_noise > 0 then i_motor + i_noise*noise.normal else i_motor;
    samples = if n_filter > 1 then cat(1, pre(samples[2:N_filter]), {0.0}) + enter*i_sample else pre(samples);
    total = pre(total) + i_sample - pre(samples[1]);
    i = if n_filter == 1 then i_sample else total/n_filter;
  end when;
end SampledCurrent;

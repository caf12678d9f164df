within WiperDrive.Electronics;
block CurrentInput "From the motor current to a number: amplifier, low-pass, converter, sampling, moving average"
  input Types.Current i_motor(start=0) "Motor current";
  parameter Types.Time T_measure = 0.001 "Period of measuring [A] as T_compute; the source left other rates out (chapter 5)";
  parameter Types.Time T_jitter = 0 "Most by which a sample is late, evenly distributed [A] off; less than T_measure";
  parameter Integer seed = 1 "Seed of noise and jitter [A] any";
  parameter Boolean amplifier = false
    "True: sense resistor and amplifier have the errors and limits below [A] off: the source gives none";
  parameter Types.Resistance R_sense = 0.01 "Sense resistor [A] usual: 1 W at 10 A";
  parameter Types.Ratio A_sense = 50 "Nominal gain of the amplifier [A] 10 A then fill the input of 5 V";
  parameter Types.Ratio gain_error = 0 "Relative error of resistor and gain together [A] the source gives none";
  parameter Types.Voltage v_offset = 0 "Offset at the amplifier's output [A] the source gives none";
  parameter Types.Voltage v_ref = 5 "Supply of the amplifier and range of the converter [S] figure 4.7: 5 V";
  parameter Types.Frequency f_lowpass = 0 "Cross-over frequency of the input's low-pass, 0: off [S] 2.4.2: about 50 Hz";
  parameter Types.Voltage v_noise = 0 "Standard deviation of the noise at the converter [A] off: the source gives none";
  parameter Integer n_bits = 0 "Bits of the converter, 0: off [A] the source gives none";
  parameter Types.Time T_filter = 0 "Length of the moving average, 0: off [S] 4.3: 0.125 s on the rig";
  final parameter Integer n_filter = max(1, integer(floor(T_filter/T_measure + 0.5)))
    "Samples in the moving average [A] T_filter to the nearest sample, at least one";
  final parameter Types.Current i_full = v_ref/(A_sense*R_sense) "Current that fills the converter's range [A] Ohm's law";
  output Types.Current i_sample(start=0, fixed=true) "Last sample";
  output Types.Current i(start=0, fixed=true) "Moving average of the samples";
  output Types.Time t_sample(start=0, fixed=true) "When it was taken";
protected
  constant Integer N_filter = 1024 "Capacity of the moving average, also the literal in `enter`";
  constant Types.Time never = 1e9 "Later than any simulation ends";
  // A relation has to be false before it can become true: two instants within a nanosecond are one.
  constant Types.Time T_late = 1e-8 "Least delay of a sample that is late";
  parameter Types.Ratio enter[N_filter] = {if k == n_filter then 1.0 else 0.0 for k in 1:1024}
    "Place at which a sample enters the moving average [A] follows from n_filter";
  parameter Types.Ratio n_codes = 2^n_bits "Steps of the converter [A] follows from n_bits";
  Noise noise(T=T_measure, seed=seed) "Random numbers of this sample";
  discrete Types.Time t_due(start=never, fixed=true) "When the next late sample is due";
  discrete Types.Time h(start=0, fixed=true) "Time since the sample before";
  discrete Types.Current i_in(start=0, fixed=true) "At the amplifier's output, referred to the motor current";
  discrete Types.Time lag(start=0, fixed=true) "Time constant of the low-pass";
  discrete Types.Ratio rest(start=0, fixed=true) "What the low-pass still remembers of the sample before";
  discrete Types.Current i_low(start=0, fixed=true) "Behind the low-pass";
  discrete Types.Current i_noisy(start=0, fixed=true) "At the converter";
  discrete Types.Current samples[N_filter](each start=0, each fixed=true) "Moving average, next to leave first";
  discrete Types.Current total(start=0, fixed=true) "Sum of the samples in the moving average";
equation
  assert(T_jitter >= 0 and T_jitter < T_measure, "T_jitter must not be negative, and must be less than T_measure.");
  assert(n_filter <= N_filter, "T_filter must not exceed 1024 periods of T_measure.");
  assert(n_bits >= 0 and n_bits <= 24, "n_bits must lie between 0 (off) and 24.");
  assert(f_lowpass >= 0, "f_lowpass must not be negative.");
  when sample(0, T_measure) then
    t_due = if T_jitter > 0 then time + max(T_late, T_jitter*noise.uniform) else never;
  end when;
  when {sample(0, T_measure) and T_jitter <= 0, time >= t_due} then
    t_sample = time;
    h = time - pre(t_sample);
    // Ohm's law, errors and limits of the amplifier
    i_in = if amplifier then
        min(max(0, (1 + gain_error)*i_motor + v_offset/(A_sense*R_sense)), i_full)
      else i_motor;
    // Low-pass of first order: exact for a current that is linear between the samples
    lag = if f_lowpass > 0 then 1/(2*Constants.pi*f_lowpass) else 0;
    rest = if lag > 0 then exp(-h/lag) else 0;
    i_low = if lag > 0 and h > 0 then
        i_in - lag*(i_in - pre(i_in))/h + (pre(i_low) - pre(i_in) + lag*(i_in - pre(i_in))/h)*rest
      else i_in;
    i_noisy = if v_noise > 0 then i_low + v_noise/(A_sense*R_sense)*noise.normal else i_low;
    // The converter rounds to the nearest code and has no code outside its range.
    i_sample = if n_bits > 0 then
        min(max(0, floor(i_noisy/i_full*n_codes + 0.5)), n_codes - 1)*i_full/n_codes
      else i_noisy;
    samples = if n_filter > 1 then cat(1, pre(samples[2:N_filter]), {0.0}) + enter*i_sample else pre(samples);
    total = pre(total) + i_sample - pre(samples[1]);
    i = if n_filter == 1 then i_sample else total/n_filter;
  end when;
end CurrentInput;

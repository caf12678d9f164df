within WiperDrive.Electronics;
block SampledECU "The controller unit as far as it acts on ticks alone, each part at a rate of its own; quick to simulate"
  extends Controllers.Controller;
  parameter Types.Time T_compute = 0.001 "Period of the chart and the output [A] as the voltage profile's";
  parameter Types.Time T_measure = 0.001 "Period of measuring [A] as T_compute; the source left other rates out (chapter 5)";
  parameter Types.Time T_sample = 0.020
    "Period of the hold through which the chart sees the current, a multiple of T_compute [S] 3.5.1: 20 ms";
  parameter Integer n_read = 1
    "Readings of the park contact per T_compute, a closed one is latched until the chart has read it [A] 1: no latch";
  parameter Integer seed = 1 "Seed of the noise [A] any";
  parameter Types.Current i_noise = 0 "Standard deviation of a sample's noise [A] off: the source gives none";
  parameter Types.Time T_filter = 0
    "Length of the moving average of the current [S] 3.5.1: the model has none; the rig of chapter 4 has 0.125 s";
  parameter Types.Time T_ramp = 0.1 "Duration of a ramp, Ts [S] table 3.5";
  parameter Types.Ratio acc_val = 0.7 "Duty ratio at which the soft start begins, AccVal [S] table 3.5";
  parameter Types.Ratio turn_val = 0.7 "Drop of the duty ratio at a turning point, TurnVal [S] table 3.5";
  parameter Integer n_window = 50 "Samples in the sliding minimum of the current [S] 3.5.1";
  parameter Types.Current i_no_load = 0.58 "No-load current, the least value of the sliding minimum [S] table 3.4";
  parameter Types.Ratio i_gain = 1.03 "Threshold over sliding minimum, i_lim_gain [S] B.1.6, line 11";
  parameter Types.Ratio duty_min = 0
    "Least duty ratio in every state but IDLE [S] 3.5.1: the model has none; the rig of chapter 4 has 0.35";
  parameter Types.Time T_blank = 0.3 "Time from the start over which the current reads zero [S] 3.5.1";
  parameter Types.Time T_delay = 0
    "Delay from reading the inputs to the output, a multiple of T_compute [A] the chart itself has none";
  parameter Types.Ratio stop_ratio = 0.5
    "Duration of the soft stop over T_ramp [S] figure 3.11: 0.5 in the chart; figure 3.12 draws 1";
  output Types.ChartState state "State of the chart";
  output Types.Current i_filtered "Moving average of the current, every T_measure";
  output Types.Current i_limit "Current below which a turning point is taken to be near";
  output Types.Time period "Half the time between the last two openings of the park contact";
  SampledCurrent current(T_measure=T_measure, seed=seed, i_noise=i_noise, T_filter=T_filter, i_motor=i_motor)
    "Measuring";
  ParkInput contact(T_compute=T_compute, n_read=n_read, park=park) "Park input";
  Controllers.VoltageProfile chart(T_compute=T_compute, T_sample=T_sample, T_ramp=T_ramp, acc_val=acc_val,
    turn_val=turn_val, n_window=n_window, i_no_load=i_no_load, i_gain=i_gain, duty_min=duty_min, T_blank=T_blank,
    T_delay=T_delay, stop_ratio=stop_ratio, i_motor=current.i, park=contact.seen, enable=enable) "Computing";
equation
  duty = chart.duty;
  state = chart.state;
  i_filtered = current.i;
  i_limit = chart.i_limit;
  period = chart.period;
end SampledECU;

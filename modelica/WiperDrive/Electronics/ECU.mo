within WiperDrive.Electronics;
block ECU "The voltage profile with the hardware around it; with every part off it is the voltage profile"
  extends Controllers.Controller;
  parameter Types.Time T_compute = 0.001 "Period of the chart, the park input and the output [A] as the voltage profile's";
  parameter Types.Time T_measure = 0.001 "Period of measuring [A] as T_compute; the source left other rates out (chapter 5)";
  parameter Types.Time T_sample = 0.020
    "Period of the hold through which the chart sees the current, a multiple of T_compute [S] 3.5.1: 20 ms";
  parameter Types.Time T_jitter = 0 "Most by which a sample is late, evenly distributed [A] off; less than T_measure";
  parameter Integer seed = 1 "Seed of noise and jitter [A] any";
  parameter Boolean amplifier = false
    "True: sense resistor and amplifier have the errors and limits below [A] off: the source gives none";
  parameter Types.Resistance R_sense = 0.01 "Sense resistor [A] usual: 1 W at 10 A";
  parameter Types.Ratio A_sense = 50 "Nominal gain of the amplifier [A] 10 A then fill the input of 5 V";
  parameter Types.Ratio gain_error = 0 "Relative error of resistor and gain together [A] the source gives none";
  parameter Types.Voltage v_offset = 0 "Offset at the amplifier's output [A] the source gives none";
  parameter Types.Voltage v_ref = 5 "Supply of the amplifier and range of the converter [S] figure 4.7: 5 V";
  parameter Types.Frequency f_lowpass = 0
    "Cross-over frequency of the current input's low-pass, 0: off [S] 2.4.2: about 50 Hz";
  parameter Types.Voltage v_noise = 0 "Standard deviation of the noise at the converter [A] off: the source gives none";
  parameter Integer n_bits = 0 "Bits of the converter, 0: off [A] the source gives none";
  parameter Types.Time T_filter = 0
    "Length of the moving average of the current [S] 3.5.1: the model has none; the rig of chapter 4 has 0.125 s";
  parameter Types.Voltage v_park = 0 "Threshold of the park input, 0: off [S] figure 4.7: 4.5 V of 5 V";
  parameter Integer n_read = 1
    "Readings of the park contact per T_compute, a closed one is latched until the chart has read it [A] 1: no latch";
  parameter Types.Frequency f_park = 0 "Cross-over frequency of the park input's low-pass, 0: off [S] 2.4.2: about 50 Hz";
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
  parameter Integer n_pwm = 0 "Steps of the output's timer from 0 to 1, 0: off [A] the source gives none";
  parameter Types.Current i_trip = 0 "Current above which the bridge latches off, 0: off [S] 4.2.2: 15 A";
  output Types.ChartState state "State of the chart";
  output Types.Current i_filtered "Moving average of the current, every T_measure";
  output Types.Current i_limit "Current below which a turning point is taken to be near";
  output Types.Time period "Half the time between the last two openings of the park contact";
  output Boolean tripped "True once the protection has latched off";
  CurrentInput current(T_measure=T_measure, T_jitter=T_jitter, seed=seed, amplifier=amplifier, R_sense=R_sense,
    A_sense=A_sense, gain_error=gain_error, v_offset=v_offset, v_ref=v_ref, f_lowpass=f_lowpass, v_noise=v_noise,
    n_bits=n_bits, T_filter=T_filter, i_motor=i_motor) "Measuring";
  ParkInput contact(T_compute=T_compute, n_read=n_read, v_park=v_park, f_lowpass=f_park, park=park) "Park input";
  Controllers.VoltageProfile chart(T_compute=T_compute, T_sample=T_sample, T_ramp=T_ramp, acc_val=acc_val,
    turn_val=turn_val, n_window=n_window, i_no_load=i_no_load, i_gain=i_gain, duty_min=duty_min, T_blank=T_blank,
    T_delay=T_delay, stop_ratio=stop_ratio, i_motor=current.i, park=contact.seen, enable=enable) "Computing";
  PowerOutput power(T_compute=T_compute, n_pwm=n_pwm, i_trip=i_trip, duty_wanted=chart.duty, i=current.i_sample,
    enable=enable) "Output";
equation
  duty = power.duty;
  state = chart.state;
  i_filtered = current.i;
  i_limit = chart.i_limit;
  period = chart.period;
  tripped = power.tripped;
end ECU;

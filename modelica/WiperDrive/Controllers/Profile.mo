within WiperDrive.Controllers;
partial block Profile "The source's current-controlled chart, section 3.5; the shape of its ramps is left open"
  extends Controller;
  replaceable function ramp = LinearRamp constrainedby Ramp "Shape of the ramps";
  parameter Types.Time T_compute = 0.001
    "Period of the chart, the park input, the analogue input and its filter [A] at 20 ms most park contacts were missed";
  parameter Types.Time T_sample = 0.020
    "Period of the hold through which the chart sees the current, a multiple of T_compute [S] 3.5.1: 20 ms";
  parameter Types.Time T_ramp = 0.1 "Duration of a ramp, Ts [S] table 3.5";
  parameter Types.Ratio acc_val = 0.7 "Duty ratio at which the soft start begins, AccVal [S] table 3.5";
  parameter Types.Ratio turn_val = 0.7 "Drop of the duty ratio at a turning point, TurnVal [S] table 3.5";
  parameter Types.Time T_filter = 0
    "Length of the moving average of the current [S] 3.5.1: the model has none; the rig of chapter 4 has 0.125 s";
  parameter Integer n_window = 50 "Samples in the sliding minimum of the current [S] 3.5.1";
  parameter Types.Current i_no_load = 0.58 "No-load current, the least value of the sliding minimum [S] table 3.4";
  parameter Types.Ratio i_gain = 1.03 "Threshold over sliding minimum, i_lim_gain [S] B.1.6, line 11";
  parameter Types.Ratio duty_min = 0
    "Least duty ratio in every state but IDLE [S] 3.5.1: the model has none; the rig of chapter 4 has 0.35";
  parameter Types.Time T_blank = 0.3 "Time from the start over which the current reads zero [S] 3.5.1";
  parameter Types.Time T_delay = 0
    "Delay from reading the inputs to the output, a multiple of T_compute [A] the chart itself has none";
  parameter Types.Time T_least = 0.1 "Half revolutions below it are taken as T_default [S] 3.5.1";
  parameter Types.Time T_default = 1 "Half revolution until one has been measured [S] 3.5.1";
  parameter Types.Ratio stop_ratio = 0.5
    "Duration of the soft stop over T_ramp [S] figure 3.11: 0.5 in the chart; figure 3.12 draws 1";
  parameter Boolean idle_step = false
    "True: between two revolutions the chart is IDLE for one T_compute [A] figure 3.12 draws no gap, the chart's arrows do";
  final parameter Integer n_hold = integer(floor(T_sample/T_compute + 0.5)) "Ticks per T_sample [S] 3.5.1";
  final parameter Integer n_filter = max(1, integer(floor(T_filter/T_compute + 0.5)))
    "Samples in the moving average [A] T_filter to the nearest tick, at least one";
  final parameter Integer n_delay = integer(floor(T_delay/T_compute + 0.5)) "Ticks of T_delay [A] to the nearest tick";
  output Types.ChartState state(start=Types.ChartState.IDLE, fixed=true) "State of the chart";
  output Types.Current i_filtered(start=0, fixed=true) "Moving average of the current, every T_compute";
  output Types.Current i_limit(start=i_gain*i_no_load, fixed=true) "Current below which a turning point is taken to be near";
  output Types.Time period(start=1, fixed=true) "Half the time between the last two openings of the park contact";
  discrete Types.Current i_real(start=0, fixed=true) "Current that the chart sees: averaged, held and blanked";
protected
  constant Integer N_filter = 1024 "Capacity of the moving average, also the literal in `enter`";
  constant Integer N_window = 256 "Capacity of the sliding minimum, also the literal in `beyond`";
  constant Integer N_delay = 64 "Capacity of the delay, also the literal in `enter_delay`";
  constant Types.Current never = 1e9 "A current that is never the least one";
  // A sample enters its shift register at the place from which it reaches the first place when it is due: the length
  // of a register can change from run to run although its capacity is fixed.
  parameter Types.Ratio enter[N_filter] = {if k == n_filter then 1.0 else 0.0 for k in 1:1024}
    "Place at which a sample enters the moving average [A] follows from n_filter";
  parameter Types.Current beyond[N_window] = {if k <= n_window then 0.0 else never for k in 1:256}
    "Keeps samples older than n_window out of the minimum [A] follows from n_window";
  parameter Types.Ratio enter_delay[N_delay] = {if k == n_delay then 1.0 else 0.0 for k in 1:64}
    "Place at which a duty ratio enters the delay [A] follows from n_delay";
  // Time is counted in whole ticks of T_compute, so that a ramp takes exactly T_ramp/T_compute of them after any
  // number of ticks. Two times closer than `same` are one, because rounding must not move a decision by a tick; it is
  // far less than a tick, since `period` is a multiple of half a tick only.
  constant Types.Time same = 1e-9 "Times closer than this are one";
  discrete Integer tick(start=-1, fixed=true) "Number of this computation, the first one is 0";
  discrete Integer tick_state(start=0, fixed=true) "Tick at which the state was entered";
  discrete Integer tick_run(start=0, fixed=true) "Tick at which the superstate RUN was entered";
  discrete Integer tick_open(start=0, fixed=true) "Tick at which the park contact last opened";
  discrete Integer hold(start=1, fixed=true) "Ticks until the next sample of the current is due";
  discrete Types.Current samples[N_filter](each start=0, each fixed=true) "Moving average, next to leave first";
  discrete Types.Current total(start=0, fixed=true) "Sum of the samples in the moving average";
  discrete Types.Current window[N_window](each start=0, each fixed=true) "Samples for the minimum, newest first";
  discrete Boolean due(start=false, fixed=true) "True when a sample of the current is due";
  discrete Boolean closed(start=true, fixed=true) "State of the park contact";
  discrete Boolean closes(start=false, fixed=true) "True when the park contact closes";
  discrete Boolean opens(start=false, fixed=true) "True when the park contact opens";
  discrete Types.Time measured(start=0, fixed=true) "Half the time between the last two openings of the contact";
  discrete Boolean running(start=false, fixed=true) "True in the superstate RUN";
  discrete Boolean ramp_over(start=false, fixed=true) "True when T_ramp is over in the state";
  discrete Boolean turn_near(start=false, fixed=true) "True when the turning point is predicted";
  discrete Boolean end_near(start=false, fixed=true) "True when the end of the revolution is predicted";
  discrete Boolean turned(start=false, fixed=true) "True once the turning point has been passed: ro of figure 3.11";
  discrete Boolean at_park(start=false, fixed=true) "True if the park contact closed at the entry into Soft_stop, or since";
  discrete Types.Time elapsed(start=0, fixed=true) "Time since the state was entered";
  discrete Types.Ratio y(start=0, fixed=true) "Output of the chart";
  discrete Types.Ratio floored(start=0, fixed=true) "Output of the chart, not below duty_min while running";
  discrete Types.Ratio delayed[N_delay](each start=0, each fixed=true) "Duty ratios on their way out, next one first";
equation
  assert(T_ramp > 0, "T_ramp must be positive.");
  assert(stop_ratio > 0, "stop_ratio must be positive.");
  assert(abs(T_sample - n_hold*T_compute) < 1e-6*T_compute and n_hold >= 1,
    "T_sample must be a multiple of T_compute, and not less than it.");
  assert(n_filter <= N_filter, "T_filter must not exceed 1024 periods of T_compute.");
  assert(n_window >= 1 and n_window <= N_window, "n_window must lie between 1 and 256.");
  assert(abs(T_delay - n_delay*T_compute) < 1e-6*T_compute and n_delay >= 0 and n_delay <= N_delay,
    "T_delay must be a multiple of T_compute, from 0 to 64 of them.");
  when sample(0, T_compute) then
    tick = pre(tick) + 1;

    // Current: moving average of the analogue input at T_compute, ...
    samples = if n_filter > 1 then cat(1, pre(samples[2:N_filter]), {0.0}) + enter*i_motor else pre(samples);
    total = pre(total) + i_motor - pre(samples[1]);
    i_filtered = if n_filter == 1 then i_motor else total/n_filter;
    // ... held for T_sample, zero for the first T_blank, ...
    due = pre(hold) <= 1;
    hold = if due then n_hold else pre(hold) - 1;
    i_real = if not due then pre(i_real) elseif tick < (T_blank - same)/T_compute then 0 else i_filtered;
    // ... and the threshold from the sliding minimum over the last n_window samples of T_sample.
    window = if due then cat(1, {i_real}, pre(window[1:N_window - 1])) else pre(window);
    i_limit = if due then i_gain*max(min(window + beyond), i_no_load) else pre(i_limit);

    // Period: half the time between two falling edges of park; what no motor can reach is replaced.
    closes = park and not pre(closed);
    opens = pre(closed) and not park;
    closed = park;
    tick_open = if opens then tick else pre(tick_open);
    measured = if opens then (tick - pre(tick_open))*T_compute/2 else pre(measured);
    period = if measured < T_least - same then T_default else measured;

    // Chart, figure 3.11: conditions. The contact on which the revolution began is ignored until it has opened: only
    // its closing counts.
    running = pre(state) == Types.ChartState.RUN or pre(state) == Types.ChartState.turn_point_dec
      or pre(state) == Types.ChartState.turn_point_acc;
    ramp_over = tick - pre(tick_state) > (T_ramp - same)/T_compute;
    turn_near = tick - pre(tick_state) > (period - 2*T_ramp + same)/T_compute and not pre(turned)
      and i_real < i_limit;
    end_near = tick - pre(tick_run) > (2*period - 2*T_ramp + same)/T_compute and pre(turned);
    // Transitions. Those out of the superstate RUN come first, the park contact before the prediction. Once enable has
    // fallen, the prediction is ignored: the wiper runs on to the contact, and coasts from there.
    state =
      if pre(state) == Types.ChartState.IDLE then
        (if enable then Types.ChartState.Soft_start else Types.ChartState.IDLE)
      elseif closes and not enable then Types.ChartState.IDLE
      elseif pre(state) == Types.ChartState.Soft_start then
        (if ramp_over then Types.ChartState.RUN else Types.ChartState.Soft_start)
      elseif running and closes then Types.ChartState.Soft_stop
      elseif running and end_near and enable then Types.ChartState.Soft_stop
      elseif pre(state) == Types.ChartState.RUN then
        (if turn_near then Types.ChartState.turn_point_dec else Types.ChartState.RUN)
      elseif pre(state) == Types.ChartState.turn_point_dec then
        (if ramp_over then Types.ChartState.turn_point_acc else Types.ChartState.turn_point_dec)
      elseif pre(state) == Types.ChartState.turn_point_acc then
        (if ramp_over then Types.ChartState.RUN else Types.ChartState.turn_point_acc)
      elseif tick - pre(tick_state) > (stop_ratio*T_ramp - same)/T_compute then
        // through IDLE and on in the same instant while enabled
        (if (enable and not idle_step) or (not enable and not pre(at_park)) then Types.ChartState.Soft_start
         else Types.ChartState.IDLE)
      else Types.ChartState.Soft_stop;
    at_park = if running and state == Types.ChartState.Soft_stop then closes else pre(at_park) or closes;
    // Entry into RUN resets ro, exit from turn_point_dec sets it.
    turned =
      if pre(state) == Types.ChartState.Soft_start and state == Types.ChartState.RUN then false
      elseif pre(state) == Types.ChartState.turn_point_dec and state <> Types.ChartState.turn_point_dec then true
      else pre(turned);
    tick_run = if pre(state) == Types.ChartState.Soft_start and state == Types.ChartState.RUN then tick
      else pre(tick_run);
    tick_state = if state <> pre(state) then tick else pre(tick_state);
    elapsed = (tick - tick_state)*T_compute;
    // Output of the states
    y =
      if state == Types.ChartState.Soft_start then acc_val + ramp(elapsed/T_ramp)*(1 - acc_val)
      elseif state == Types.ChartState.RUN then 1
      elseif state == Types.ChartState.turn_point_dec then 1 - ramp(elapsed/T_ramp)*turn_val
      elseif state == Types.ChartState.turn_point_acc then 1 - turn_val + ramp(elapsed/T_ramp)*turn_val
      elseif state == Types.ChartState.Soft_stop then 1 - ramp(elapsed/(stop_ratio*T_ramp))*(1 - acc_val)
      else 0;
    floored = if state == Types.ChartState.IDLE then 0 else max(y, duty_min);

    // Computation delay
    delayed = if n_delay > 0 then cat(1, pre(delayed[2:N_delay]), {0.0}) + enter_delay*floored else pre(delayed);
    duty = if n_delay == 0 then floored else pre(delayed[1]);
  end when;
end Profile;

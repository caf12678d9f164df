package TimeEvents "Relations whose change is known beforehand"
  model Pulses "Pulses of a length that a clock fixes, on a coil"
    parameter Real T(unit="s") = 1e-3 "Period";
    parameter Real L(unit="H") = 3.75e-3 "Inductance";
    parameter Real R(unit="Ohm") = 1.91 "Resistance";
    parameter Real U(unit="V") = 28 "Supply";
    input Real duty(unit="1", start=0.3) "Duty ratio";
    output Real i(unit="A", start=0, fixed=true) "Current";
    output Boolean on "True during a pulse";
    discrete Real t_off(unit="s", start=0, fixed=true) "End of the pulse";
  equation
    when sample(0, T) then
      t_off = time + duty*T;
    end when;
    on = time < t_off;
    L*der(i) + R*i = if on then U else 0;
  end Pulses;

  model Registers "Clocked registers that take from each other what was there before the tick"
    parameter Real T(unit="s") = 0.1 "Period of the fast clock; the slow one has twice the period";
    parameter Boolean enabled = true "Whether the fast clock shifts";
    input Real u(unit="1", start=1) "Shifted in";
    discrete output Real up[40](each unit="1", each start=0, each fixed=true) "Shifted towards the beginning";
    discrete output Real down[40](each unit="1", each start=0, each fixed=true) "Shifted likewise, with what leaves up";
    discrete output Real copy[40](each unit="1", each start=0, each fixed=true) "What up was before, slowly";
    discrete output Real a(unit="1", start=3, fixed=true) "Changes places with b";
    discrete output Real b(unit="1", start=5, fixed=true) "Changes places with a";
    discrete output Real total(unit="1", start=0, fixed=true) "Of the ends of up before each slow tick";
  equation
    when sample(0, T) then
      a = pre(b);
      b = pre(a);
    end when;
    when sample(0, T) then
      for k in 1:39 loop
        up[k] = if enabled then pre(up[k + 1]) else pre(up[k]);
        down[k] = if enabled then pre(down[k + 1]) + pre(up[k]) else pre(down[k]);
      end for;
      up[40] = if enabled then u else pre(up[40]);
      down[40] = if enabled then u + pre(a) else pre(down[40]);
    end when;
    when sample(0, 2*T) then
      for k in 1:40 loop
        copy[k] = pre(up[k]) - pre(copy[k]) + pre(a);
      end for;
      total = pre(up[1]) + 2*pre(up[40]);
    end when;
  end Registers;

  model Handed "What a tick decides, and what follows from it at once"
    parameter Real T(unit="s") = 0.1 "Period of the clock";
    input Boolean u(start=true) "Known at all times";
    output Boolean on(start=false, fixed=true) "Changes at each tick";
    output Boolean off "Follows at once";
    output Boolean both "Follows from that and the input";
    output Boolean same "Hands both on";
    output Integer n(start=0, fixed=true) "Ticks after which same is true";
  equation
    when sample(0, T) then
      on = not pre(on);
    end when;
    off = not on;
    both = off and u;
    same = both;
    when sample(0, T) then
      n = if same then pre(n) + 1 else pre(n);
    end when;
  end Handed;

  model Beats "The same, with what is over after a tick"
    extends Handed;
    output Boolean beat "True at the ticks alone";
    output Boolean settled "What off was in the pass before the last one of an event";
  equation
    beat = sample(0, T);
    settled = pre(off);
  end Beats;

  model Instants "Each instant fixes the next one; the distance grows"
    parameter Real first(unit="s") = 0.5 "First instant";
    parameter Real step(unit="s") = 0.125 "First distance, and what each is longer than the one before";
    discrete Real t_next(unit="s", start=first, fixed=true) "Next instant";
    output Real seen(unit="s", start=-1, fixed=true) "Last instant as it was computed";
    output Integer n(start=0, fixed=true) "How many there were";
  equation
    when time >= pre(t_next) then
      n = pre(n) + 1;
      seen = time;
      t_next = pre(t_next) + n*step;
    end when;
  end Instants;

  model Alarm "A state event fixes the instant of a time event, inside the step that the solver was about to take"
    parameter Real wait(unit="s") = 1e-3 "Time from the crossing to the alarm";
    output Real x(unit="1", start=0, fixed=true) "Rises exponentially to one";
    output Real y(unit="s", start=0, fixed=true) "Time since the alarm";
    output Boolean alarm "True from the alarm on";
    discrete Real t_alarm(unit="s", start=1e9, fixed=true) "Instant of the alarm";
    constant Real tau(unit="s") = 1 "Time constant";
  equation
    tau*der(x) = 1 - x;
    when x > 0.5 then
      t_alarm = time + wait;
    end when;
    alarm = time >= t_alarm;
    der(y) = if alarm then 1 else 0;
  end Alarm;

  model Two "A relation that changes together with a clock is seen by it"
    parameter Real T(unit="s") = 0.1 "Period of the clock";
    discrete Real t_next(unit="s", start=3*0.1, fixed=true) "Instant of the relation";
    output Integer early(start=0, fixed=true) "Ticks before the relation has changed";
    output Integer late(start=0, fixed=true) "Ticks after, and together";
  protected
    Boolean over "True once the relation has changed";
  equation
    over = time >= t_next;
    when sample(0, T) then
      early = pre(early) + (if over then 0 else 1);
      late = pre(late) + (if over then 1 else 0);
    end when;
    when time >= 1e9 then
      t_next = time;
    end when;
  end Two;
end TimeEvents;

within WiperDrive.Electronics;
block ParkInput "Input of the park contact: low-pass, threshold, latch"
  input Boolean park(start=true) "True on the park contact";
  parameter Types.Time T_compute = 0.001 "Period at which the chart reads the input [A] as the chart's";
  parameter Integer n_read = 1
    "Readings per T_compute, a closed contact in any of them is latched until the chart has read it [A] 1: no latch";
  parameter Types.Voltage v_park = 0 "Threshold above which the contact counts as closed, 0: off [S] figure 4.7: 4.5 V";
  parameter Types.Voltage v_closed = 5 "Voltage for a closed contact, after the logic's inversion [S] figure 4.7: 5 V";
  parameter Types.Frequency f_lowpass = 0 "Cross-over frequency of the input's low-pass, 0: off [S] 2.4.2: about 50 Hz";
  output Boolean seen(start=true, fixed=true) "True if the contact counts as closed, or has since the chart's last tick";
  output Types.Voltage v(start=v_closed, fixed=true) "Voltage behind the low-pass";
protected
  discrete Integer reading(start=-1, fixed=true) "Readings since the last one at a tick of the chart";
  discrete Types.Voltage v_contact(start=v_closed, fixed=true) "Voltage before the low-pass";
  discrete Types.Ratio rest(start=0, fixed=true) "What the low-pass still remembers of one reading before";
  discrete Boolean closed(start=true, fixed=true) "True if the contact counts as closed in this reading";
equation
  assert(v_park < v_closed, "v_park must be less than v_closed, or the contact is never seen.");
  assert(f_lowpass >= 0, "f_lowpass must not be negative.");
  assert(n_read >= 1, "n_read must be at least 1.");
  when sample(0, T_compute/n_read) then
    reading = if pre(reading) + 1 >= n_read then 0 else pre(reading) + 1;
    v_contact = if park then v_closed else 0;
    // Low-pass of first order: exact for a contact that changes at the readings only
    rest = if f_lowpass > 0 then exp(-2*Constants.pi*f_lowpass*T_compute/n_read) else 0;
    v = if f_lowpass > 0 then pre(v_contact) + (pre(v) - pre(v_contact))*rest else v_contact;
    closed = if v_park > 0 then v > v_park else v > v_closed/2;
    // The latch: what the chart has not read yet is kept. It has read what was latched up to a reading of number 0.
    seen = closed or (pre(reading) > 0 and pre(seen));
  end when;
end ParkInput;

model OrderInWhen "Equations of a when-clause that use each other's results, among them elements of an array"
  Real x(unit="1", start=1, fixed=true) "State";
  Real v[2](each unit="1", each start=0, each fixed=true) "Levels";
equation
  der(x) = -x;
  when x < 0.5 then
    v[2] = 2*v[1];
    v[1] = time;
  end when;
end OrderInWhen;

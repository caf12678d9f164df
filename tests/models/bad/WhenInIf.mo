model WhenInIf "A when-clause that only one branch of an if-equation has"
  parameter Boolean bouncing = true "Whether it comes back";
  Real x(unit="1", start=1, fixed=true) "State";
equation
  der(x) = -1;
  if bouncing then
    when x < 0.5 then
      reinit(x, 1);
    end when;
  else
    when x < 0.2 then
      reinit(x, 2);
    end when;
  end if;
end WhenInIf;

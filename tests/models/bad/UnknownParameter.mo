model UnknownParameter "Sets a parameter that the component does not have"
  model Lag "Lag"
    parameter Real T(unit="s") = 1 "Time constant";
    Real x(unit="1", start=1, fixed=true) "State";
  equation
    T*der(x) = -x;
  end Lag;
  Lag lag(tau=2) "Lag";
end UnknownParameter;

model Clocked "A clocked counter"
  Real n(start=0) "Count";
equation
  when Clock(0.1) then
    n = previous(n) + 1;
  end when;
end Clocked;

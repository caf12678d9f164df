model Terminal "Acts at the end"
  Integer n(start=0, fixed=true) "Ends";
equation
  when terminal() then
    n = pre(n) + 1;
  end when;
end Terminal;

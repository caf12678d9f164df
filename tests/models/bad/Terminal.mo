model Terminal "terminal() outside the condition of a when-clause"
  Real y "Whether it ends";
equation
  y = if terminal() then 1 else 0;
end Terminal;

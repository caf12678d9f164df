model SyntaxError "Lacks a semicolon"
  Real x(unit="1", start=1, fixed=true) "State"
equation
  der(x) = -x;
end SyntaxError;

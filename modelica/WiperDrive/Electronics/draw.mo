within WiperDrive.Electronics;
function draw "Thirteen numbers of the combined generator of P. L'Ecuyer, Communications of the ACM 31 (1988) 742-749"
  input Types.Ratio s[2] "State of the generator, whole numbers";
  output Types.Ratio r[15] "Thirteen numbers, each evenly distributed between 0 and 1, then the new state";
protected
  Types.Ratio x "State of the first sequence";
  Types.Ratio y "State of the second sequence";
algorithm
  x := s[1];
  y := s[2];
  // Every product stays below 2^47: exact in double precision, and the same on all machines. The period is 2.3e18.
  for k in 1:13 loop
    x := mod(40014*x, 2147483563);
    y := mod(40692*y, 2147483399);
    r[k] := (if x > y then x - y else x - y + 2147483562)/2147483563;
  end for;
  r[14] := x;
  r[15] := y;
end draw;

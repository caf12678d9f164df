within WiperDrive.Electronics;
function seeds "State of the random generator for a seed: each of its two sequences begins somewhere else"
  input Integer seed "Any number from 0 on";
  output Types.Ratio s[2] "State of the generator";
algorithm
  // 1 <= s < modulus, as the generator needs it; a few million seeds lie far apart in both sequences
  s[1] := 1 + mod(69069*seed + 12345, 2147483562);
  s[2] := 1 + mod(1664525*seed + 67890, 2147483398);
end seeds;

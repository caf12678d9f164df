within WiperDrive;
package Constants "Mathematical and physical constants"
  constant Types.Ratio pi = 3.14159265358979323846 "Ratio of a circle's circumference to its diameter";
  constant Types.Acceleration g = 9.80665 "Standard acceleration of gravity [S] B.1.6, line 1";
end Constants;

within WiperDrive.Planar;
model LinkageGeometry "Lengths of the linkage from the catalogue points, by the formulas of the source's scripts"
  // The scripts pair points across the sides (PT_DS lies 72.6 mm from PT_F, yet g_DS uses PT_E) and correct three
  // lengths by hand. Both are kept as they are: without the corrections the passenger side would not be a crank-rocker.
  parameter Types.Length PT_E[3] = {1.48025, -0.80817, 1.48642} "Catalogue point E [S] B.1.2, line 8";
  parameter Types.Length PT_F[3] = {1.35491, 0.08232, 1.49436} "Catalogue point F [S] B.1.2, line 9";
  parameter Types.Length PT_DS[3] = {1.37626, 0.03213, 1.44637} "Rocker end of the DS coupler [S] B.1.2, line 17";
  parameter Types.Length PT_PS[3] = {1.41618, -0.87637, 1.43476} "Rocker end of the PS coupler [S] B.1.2, line 18";
  parameter Types.Length PT_MDS[3] = {1.38333, -0.42893, 1.41880} "Crank end of the DS coupler [S] B.1.2, line 19";
  parameter Types.Length PT_MPS[3] = {1.37236, -0.42921, 1.41958} "Crank end of the PS coupler [S] B.1.2, line 20";
  parameter Types.Length lever_M = 0.055 "Crank length [S] B.1.2, line 14";
  parameter Types.Length lever_DS = 0.07644 "Rocker length of the driver side [S] B.1.2, line 12";
  parameter Types.Length lever_PS = 0.06711 "Rocker length of the passenger side [S] B.1.2, line 13";
  parameter Types.Angle angle_offset = 2.2*Constants.pi/180 "Crank angle of the catalogue points [S] B.1.2, line 22: 2.2 deg";
  parameter Types.Length corr3D[3] = {0.002, -0.026, 0.015} "Corrections from three to two dimensions [S] B.1.3, line 2";
  final parameter Types.Length PT_M[3] = {
    PT_MDS[1] + lever_M*sin(angle_offset), PT_MDS[2] + lever_M*cos(angle_offset), PT_MDS[3]} "Crank axle [S] B.1.2, line 23";
  final parameter Types.Length a = lever_M "Crank length [S] B.1.3, line 3";
  final parameter Types.Length b_DS = lever_DS "Rocker length of the driver side [S] B.1.3, line 4";
  final parameter Types.Length b_PS = lever_PS "Rocker length of the passenger side [S] B.1.3, line 5";
  final parameter Types.Length f_DS = corr3D[2]
    + sqrt((PT_MDS[1] - PT_DS[1])^2 + (PT_MDS[2] - PT_DS[2])^2 + (PT_MDS[3] - PT_DS[3])^2)
    "Coupler length of the driver side [S] B.1.3, line 6";
  final parameter Types.Length f_PS = corr3D[3]
    + sqrt((PT_MPS[1] - PT_PS[1])^2 + (PT_MPS[2] - PT_PS[2])^2 + (PT_MPS[3] - PT_PS[3])^2)
    "Coupler length of the passenger side [S] B.1.3, line 7";
  final parameter Types.Length g_DS =
    sqrt((PT_M[1] - PT_E[1])^2 + (PT_M[2] - PT_E[2])^2 + (PT_M[3] - PT_E[3])^2)
    "Ground length of the driver side [S] B.1.3, line 8";
  final parameter Types.Length g_PS = -corr3D[1]
    + sqrt((PT_M[1] - PT_F[1])^2 + (PT_M[2] - PT_F[2])^2 + (PT_M[3] - PT_F[3])^2)
    "Ground length of the passenger side [S] B.1.3, line 9";
  final parameter Types.Angle phi_DS = atan((PT_E[3] - PT_M[3])/abs(PT_E[2] - PT_M[2]))
    "Ground angle of the driver side [S] B.1.3, line 12";
  final parameter Types.Angle phi_PS = atan((PT_F[3] - PT_M[3])/abs(PT_F[2] - PT_M[2]))
    "Ground angle of the passenger side [S] B.1.3, line 13";
  final parameter Types.Length x_B_DS = g_DS*cos(phi_DS) "x position of B on the driver side [S] B.1.4, line 9";
  final parameter Types.Length y_B_DS = g_DS*sin(phi_DS) "y position of B on the driver side [S] B.1.4, line 9";
  final parameter Types.Length x_B_PS = -g_PS*cos(phi_PS) "x position of B on the passenger side [S] B.1.4, line 10";
  final parameter Types.Length y_B_PS = g_PS*sin(phi_PS) "y position of B on the passenger side [S] B.1.4, line 10";
end LinkageGeometry;

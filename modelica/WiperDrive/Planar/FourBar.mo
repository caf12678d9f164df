within WiperDrive.Planar;
model FourBar "Coupler and rocker: a four-bar linkage without its crank"
  parameter Types.Length f = 0.4359 "Coupler length, from D to C [A] set by the model that uses it";
  parameter Types.Length b = 0.07644 "Rocker length, from B to C [A] set by the model that uses it";
  parameter Types.Length x_B = 0.4442 "x position of the rocker axle B [A] set by the model that uses it";
  parameter Types.Length y_B = 0.0692 "y position of the rocker axle B [A] set by the model that uses it";
  parameter Types.Length x_D = 0.055 "x position of the crank pin D at the start [A] set by the model that uses it";
  parameter Types.Length y_D = 0 "y position of the crank pin D at the start [A] set by the model that uses it";
  parameter Types.Ratio branch = 1 "+1: first circle intersection of B.2.2, -1: the second [A] set by the model that uses it";
  parameter Types.RotationalDamping d = 1.5e-2*180/Constants.pi
    "Damping of each of the joints B, C and D [S] table 3.1: 1.5e-2 N.m.s/deg";
  parameter Types.RotationalStiffness c = 1e-9*180/Constants.pi
    "Stiffness of each of the joints B, C and D [S] table 3.1: 1e-9 N.m/deg";
  parameter Types.Acceleration gy = 0 "Gravity in y [S] B.1.6, line 1";
  // The start position, as the circle intersection of B.2.2. These are guesses only: they choose the branch.
  final parameter Types.Length r_0 = sqrt((x_B - x_D)^2 + (y_B - y_D)^2) "Distance from D to B at the start [S] B.2.2";
  final parameter Types.Length s_0 = (f^2 - b^2 + r_0^2)/(2*r_0)
    "Distance along D to B to the foot of C at the start [S] B.2.2";
  final parameter Types.Length h_0 = branch*sqrt(f^2 - s_0^2) "Distance of C from the line D to B at the start [S] B.2.2";
  final parameter Types.Length x_C = x_D + (s_0*(x_B - x_D) + h_0*(y_B - y_D))/r_0
    "x position of C at the start [S] B.2.2";
  final parameter Types.Length y_C = y_D + (s_0*(y_B - y_D) - h_0*(x_B - x_D))/r_0
    "y position of C at the start [S] B.2.2";
  final parameter Types.Angle phi_f_0 = atan2(y_C - y_D, x_C - x_D) "Coupler orientation at the start [S] B.2.2";
  final parameter Types.Angle phi_b_0 = atan2(y_C - y_B, x_C - x_B) "Rocker orientation at the start [S] B.2.2";
  Interfaces.Frame pin "Crank pin D";
  Interfaces.Flange shaft "Rocker shaft at B";
  Revolute joint_D(d=d, c=c) "Crank pin to coupler";
  Bar coupler(L=f, gy=gy, phi(start=phi_f_0)) "From D to C";
  Revolute joint_C(d=d, c=c) "Coupler to rocker";
  Bar rocker(L=b, gy=gy, phi(start=phi_b_0)) "From B to C";
  Revolute joint_B(d=d, c=c) "Ground to rocker";
  Fixed ground(x=x_B, y=y_B) "Rocker axle B";
  Types.Power P_loss "Power turned into heat in the joints";
  Types.Energy E_kinetic "Kinetic energy of the bars";
  Types.Energy E_potential "Potential energy of the bars and the joints' stiffness";
equation
  connect(pin, joint_D.frame_a);
  connect(joint_D.frame_b, coupler.frame_a);
  connect(coupler.frame_b, joint_C.frame_a);
  connect(joint_C.frame_b, rocker.frame_b);
  connect(ground.frame, joint_B.frame_a);
  connect(joint_B.frame_b, rocker.frame_a);
  connect(joint_B.flange, shaft);
  P_loss = joint_B.P_loss + joint_C.P_loss + joint_D.P_loss;
  E_kinetic = coupler.E_kinetic + rocker.E_kinetic;
  E_potential = coupler.E_potential + rocker.E_potential
    + joint_B.E_potential + joint_C.E_potential + joint_D.E_potential;
end FourBar;

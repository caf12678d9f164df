within WiperDrive.Loads;
model GravityArm "Weight on an arm in the vertical plane, as on the lifetime-test rig of figure 4.4"
  parameter Types.Mass m = 2.35 "Mass [S] chapter 4";
  parameter Types.Length l = 0.25 "Distance from the shaft to the mass [S] chapter 4";
  parameter Types.Angle phi_0 = 3*Constants.pi/2 "Arm angle at shaft angle zero [S] chapter 4: 270 deg, hanging";
  parameter Types.Acceleration g = Constants.g "Gravity [S] B.1.6, line 1";
  final parameter Types.MomentOfInertia J = m*l^2 "Moment of inertia [A] a point mass";
  Interfaces.Flange flange "Shaft";
  Types.Angle phi_arm "Angle of the arm, counter-clockwise from horizontal";
  Types.AngularVelocity w "Speed of the arm";
  Types.Energy E_kinetic "Kinetic energy";
  Types.Energy E_potential "Potential energy, zero while the arm is horizontal";
equation
  phi_arm = flange.phi + phi_0;
  w = der(flange.phi);
  // balance of angular momentum about the shaft
  J*der(w) = flange.tau - m*g*l*cos(phi_arm);
  E_kinetic = J*w^2/2;
  E_potential = m*g*l*sin(phi_arm);
end GravityArm;

within WiperDrive.Planar;
model Revolute "Revolute joint with damping and stiffness, driven through a flange"
  parameter Types.RotationalDamping d = 0 "Damping [A] set by the model that uses it";
  parameter Types.RotationalStiffness c = 0 "Stiffness [A] set by the model that uses it";
  parameter Types.Angle phi_eq = 0 "Angle at which the stiffness gives no torque [A] Simscape's default";
  Interfaces.Frame frame_a "First body";
  Interfaces.Frame frame_b "Second body";
  Interfaces.Flange flange "Torque on the second body, reacted by the first";
  Types.Angle phi "Angle of the second body relative to the first";
  Types.AngularVelocity w "Relative speed";
  Types.Torque tau "Torque on the second body";
  Types.Power P_loss "Power turned into heat";
  Types.Energy E_potential "Energy of the spring";
equation
  // the joint keeps the two points together
  frame_a.x = frame_b.x;
  frame_a.y = frame_b.y;
  frame_b.phi = frame_a.phi + phi;
  w = der(phi);
  // balance of forces and torques
  frame_a.fx + frame_b.fx = 0;
  frame_a.fy + frame_b.fy = 0;
  frame_a.t + frame_b.t = 0;
  frame_b.t = -tau;
  // drive, viscous damping and spring
  flange.phi = phi;
  tau = flange.tau - d*w - c*(phi - phi_eq);
  P_loss = d*w^2;
  E_potential = c*(phi - phi_eq)^2/2;
end Revolute;

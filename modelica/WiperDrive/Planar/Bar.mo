within WiperDrive.Planar;
model Bar "Uniform slender rod"
  parameter Types.Length L = 1 "Length from frame_a to frame_b [A] set by the model that uses it";
  parameter Types.Density density = 8000 "Density [S] table 3.1";
  parameter Types.Length width = 0.020 "Width of the cross-section [A] the source gives none";
  parameter Types.Length thickness = 0.008 "Thickness of the cross-section [A] the source gives none";
  parameter Types.Acceleration gy = 0 "Gravity in y [S] B.1.6, line 1";
  final parameter Types.Mass m = density*width*thickness*L "Mass [S] table 3.1: density times volume";
  final parameter Types.MomentOfInertia J = m*L^2/12 "Moment of inertia about the centre [A] uniform slender rod";
  Interfaces.Frame frame_a "One end";
  Interfaces.Frame frame_b "Other end";
  Types.Length x "x position of the centre";
  Types.Length y "y position of the centre";
  Types.Angle phi "Orientation, from frame_a to frame_b";
  Types.Velocity vx "Velocity of the centre in x";
  Types.Velocity vy "Velocity of the centre in y";
  Types.AngularVelocity w "Angular velocity";
  Types.Energy E_kinetic "Kinetic energy";
  Types.Energy E_potential "Potential energy, zero at y = 0";
equation
  // rigid body
  phi = frame_a.phi;
  phi = frame_b.phi;
  x = frame_a.x + L/2*cos(phi);
  y = frame_a.y + L/2*sin(phi);
  frame_b.x = frame_a.x + L*cos(phi);
  frame_b.y = frame_a.y + L*sin(phi);
  vx = der(x);
  vy = der(y);
  w = der(phi);
  // balance of forces
  m*der(vx) = frame_a.fx + frame_b.fx;
  m*der(vy) = frame_a.fy + frame_b.fy + m*gy;
  // balance of torques about the centre
  J*der(w) = frame_a.t + frame_b.t
    + L/2*(sin(phi)*(frame_a.fx - frame_b.fx) - cos(phi)*(frame_a.fy - frame_b.fy));
  E_kinetic = m*(vx^2 + vy^2)/2 + J*w^2/2;
  E_potential = -m*gy*y;
end Bar;

within WiperDrive.Planar;
model DualFourBar "Two crank-rocker linkages on one crank: driver side (DS) and passenger side (PS)"
  parameter Types.RotationalDamping d = 1.5e-2*180/Constants.pi
    "Damping of each of the six passive joints [S] table 3.1: 1.5e-2 N.m.s/deg";
  parameter Types.RotationalStiffness c = 1e-9*180/Constants.pi
    "Stiffness of each of the six passive joints [S] table 3.1: 1e-9 N.m/deg";
  parameter Types.Acceleration gy = 0 "Gravity in y [S] B.1.6, line 1";
  LinkageGeometry geometry "Lengths from the catalogue points";
  Interfaces.Flange crank_shaft "Crank axle A, driven by the gear";
  Interfaces.Flange shaft_ds "Rocker shaft B of the driver side";
  Interfaces.Flange shaft_ps "Rocker shaft B of the passenger side";
  Fixed ground "Crank axle A";
  Revolute joint_A "Ground to crank, driven: no damping of its own [A] it belongs to the motor";
  Bar crank(L=geometry.a, gy=gy) "From A to D";
  FourBar ds(f=geometry.f_DS, b=geometry.b_DS, x_B=geometry.x_B_DS, y_B=geometry.y_B_DS, x_D=geometry.a, y_D=0,
    branch=1, d=d, c=c, gy=gy) "Driver side";
  FourBar ps(f=geometry.f_PS, b=geometry.b_PS, x_B=geometry.x_B_PS, y_B=geometry.y_B_PS, x_D=geometry.a, y_D=0,
    branch=-1, d=d, c=c, gy=gy) "Passenger side";
  Types.Power P_loss "Power turned into heat in the joints";
  Types.Energy E_kinetic "Kinetic energy of the bars";
  Types.Energy E_potential "Potential energy of the bars and the joints' stiffness";
equation
  connect(ground.frame, joint_A.frame_a);
  connect(joint_A.flange, crank_shaft);
  connect(joint_A.frame_b, crank.frame_a);
  connect(crank.frame_b, ds.pin);
  connect(crank.frame_b, ps.pin);
  connect(ds.shaft, shaft_ds);
  connect(ps.shaft, shaft_ps);
  P_loss = ds.P_loss + ps.P_loss;
  E_kinetic = crank.E_kinetic + ds.E_kinetic + ps.E_kinetic;
  E_potential = crank.E_potential + ds.E_potential + ps.E_potential;
end DualFourBar;

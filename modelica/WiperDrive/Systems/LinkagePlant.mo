within WiperDrive.Systems;
model LinkagePlant "Wiper drive with the two four-bar linkages and the load of the blades"
  extends Drive;
  parameter Types.Torque ext_load = 3 "External load on each rocker [S] table 3.2";
  parameter Boolean naive_load = false
    "True: the naive estimate of the load instead of equation 3.1 [S] figure 3.4, which figures 3.5 and 3.6 show";
  parameter Types.RotationalDamping d_joint = 1.5e-2*180/Constants.pi
    "Damping of each of the six passive joints [S] table 3.1: 1.5e-2 N.m.s/deg";
  parameter Types.RotationalStiffness c_joint = 1e-9*180/Constants.pi
    "Stiffness of each of the six passive joints [S] table 3.1: 1e-9 N.m/deg";
  parameter Types.MomentOfInertia J_arm = 0 "Inertia of each wiper arm about its rocker axle B [S] 3.1: none is modelled";
  parameter Types.Acceleration gy = 0 "Gravity in the linkage plane, in y [S] B.1.6, line 1";
  output Types.Angle phi_ds "Orientation of the driver side's rocker, from B to C, unwrapped";
  output Types.AngularVelocity w_ds "Speed of the driver side's rocker";
  output Types.Torque tau_ds "Load of equation 3.1 on the driver side's rocker, with the sign of its speed";
  output Types.Angle phi_ps "Orientation of the passenger side's rocker, from B to C, unwrapped";
  output Types.AngularVelocity w_ps "Speed of the passenger side's rocker";
  output Types.Torque tau_ps "Load of equation 3.1 on the passenger side's rocker, with the sign of its speed";
  Planar.DualFourBar linkage(d=d_joint, c=c_joint, gy=gy) "Linkage";
  Rotational.Inertia arm_ds(J=J_arm) "Wiper arm of the driver side";
  Rotational.Inertia arm_ps(J=J_arm) "Wiper arm of the passenger side";
  Loads.WiperLoad load_ds(ext_load=ext_load, naive=naive_load, phi_crank=phi_crank) "Load of the driver side";
  Loads.WiperLoad load_ps(ext_load=ext_load, naive=naive_load, phi_crank=phi_crank) "Load of the passenger side";
  Types.Power P_joints "Power turned into heat in the joints";
  Types.Power P_load "Power taken by the load";
  Types.Energy E_kinetic "Kinetic energy";
  Types.Energy E_potential "Potential energy";
equation
  connect(gear.flange_b, linkage.crank_shaft);
  connect(linkage.shaft_ds, arm_ds.flange_a);
  connect(linkage.shaft_ps, arm_ps.flange_a);
  connect(arm_ds.flange_b, load_ds.flange);
  connect(arm_ps.flange_b, load_ps.flange);
  phi_ds = linkage.ds.rocker.phi;
  w_ds = linkage.ds.rocker.w;
  tau_ds = load_ds.tau;
  phi_ps = linkage.ps.rocker.phi;
  w_ps = linkage.ps.rocker.w;
  tau_ps = load_ps.tau;
  P_joints = linkage.P_loss;
  P_load = load_ds.P + load_ps.P;
  E_kinetic = motor.rotor.E_kinetic + linkage.E_kinetic + arm_ds.E_kinetic + arm_ps.E_kinetic;
  E_potential = linkage.E_potential;
end LinkagePlant;

within WiperDrive.Tests;
model LinkageEnergy "Balance of energy of the linkage plant over a start, a soft turn and disturbances"
  Systems.LinkagePlant plant(J_arm=0.05, gy=-Constants.g, c_joint=0.1,
    duty=if time < 1.5 then 1 elseif time < 1.6 then 0.1 else 0.8,
    v_supply=28,
    tau_disturbance=if time < 0.5 then 0 elseif time < 0.7 then 5 else -2) "Plant";
  Types.Energy E_in(start=0, fixed=true) "Energy given by the supply and the surroundings";
  Types.Energy E_out(start=0, fixed=true) "Energy turned into heat and taken by the load";
  Types.Energy E_stored "Energy of the motion, the position and the magnetic fields";
  Types.Energy E_0 "Energy stored at the start";
  Types.Energy E_error "What the balance of energy leaves over";
initial equation
  E_0 = E_stored;
equation
  der(E_0) = 0;
  der(E_in) = plant.P_supply + plant.P_disturbance;
  der(E_out) = plant.P_copper + plant.P_rotor + plant.P_gear + plant.P_joints + plant.P_load;
  E_stored = plant.E_kinetic + plant.E_potential + plant.E_magnetic;
  // conservation of energy
  E_error = E_stored - E_0 + E_out - E_in;
end LinkageEnergy;

within WiperDrive.Systems;
model RigClosedLoop "Rig plant and voltage profile in one model: the reference for their co-simulation"
  input Types.Voltage v_supply(start=28) "Supply voltage";
  input Types.Torque tau_disturbance(start=0)
    "Torque of the surroundings on the gear's output shaft, positive in the direction of rotation";
  input Boolean enable(start=true) "True while the wiper is to run";
  RigPlant plant(duty=controller.duty, v_supply=v_supply, tau_disturbance=tau_disturbance) "Plant";
  Controllers.VoltageProfile controller(i_motor=plant.i_motor, park=plant.park, enable=enable) "Controller";
end RigClosedLoop;

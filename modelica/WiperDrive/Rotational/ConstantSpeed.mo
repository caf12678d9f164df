within WiperDrive.Rotational;
model ConstantSpeed "Turns a shaft steadily, whatever torque it takes"
  parameter Types.AngularVelocity w = 1 "Speed [A] set by the model that uses it";
  Interfaces.Flange flange "Shaft";
equation
  flange.phi = w*time;
end ConstantSpeed;

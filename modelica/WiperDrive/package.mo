package WiperDrive "Windscreen wiper drive of a truck: motor, worm gear, two four-bar linkages, load and controller"
  annotation(
    version="1.0.0",
    Documentation(info="<html>
<p>An acausal model of the drive in P. Fjellander, <i>Robust and Adaptive Motion Control for Windscreen Wiping on
Commercial Vehicles</i>, KTH 2018 (TRITA-ITM-EX 2018:162), called &quot;the source&quot; here.</p>
<p>The description of every parameter ends with its provenance: <b>[S]</b> and the place in the source that states it,
or <b>[A]</b> and the reason why it was assumed, because the source gives no value.</p>
<p>Units are SI, angles in radians. A positive power flows in the direction of rotation. A torque, a force or a current
at a connector is positive when it flows into the component.</p>
</html>"));
end WiperDrive;

model Stream "A connector with a stream variable"
  connector Port "Fluid"
    Real p(unit="Pa") "Pressure";
    flow Real m(unit="kg/s") "Mass flow";
    stream Real h(unit="J/kg") "Specific enthalpy";
  end Port;
  Port port "Port";
equation
  port.p = 1;
  port.h = inStream(port.h);
end Stream;

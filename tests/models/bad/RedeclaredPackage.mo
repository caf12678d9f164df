model RedeclaredPackage "Two components with two packages of constants"
  package Water "Medium"
    constant Real rho(unit="kg/m3") = 1000 "Density";
  end Water;
  package Oil "Medium"
    extends Water(rho=900);
  end Oil;
  model Tank "Tank"
    replaceable package Medium = Water;
    parameter Real m(unit="kg") = Medium.rho*0.1 "Mass";
    Real x(unit="1", start=1, fixed=true) "State";
  equation
    der(x) = -x;
  end Tank;
  Tank water "Would have the density of oil";
  Tank oil(redeclare package Medium = Oil) "Oil";
end RedeclaredPackage;

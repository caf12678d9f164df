model RedeclaredInherited "Redeclares a component that the extended class has inherited"
  partial model P "Something with a value"
    Real y "Value";
  end P;
  model A "One"
    extends P;
  equation
    y = 1;
  end A;
  model B "Two"
    extends P;
  equation
    y = 2;
  end B;
  model D "Declares it"
    replaceable A c constrainedby P "Component";
  end D;
  model E "Inherits it"
    extends D;
  end E;
  extends E(redeclare B c);
end RedeclaredInherited;

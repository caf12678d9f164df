model ConnectInIf "A connection that a parameter decides"
  connector Pin "Pin"
    Real v(unit="V") "Potential";
    flow Real i(unit="A") "Current";
  end Pin;
  parameter Boolean closed = true "Whether there is a connection";
  Pin a "First";
  Pin b "Second";
equation
  a.v = 1;
  if closed then
    connect(a, b);
  end if;
end ConnectInIf;

within Small;
model Collisions "Three carts on a line run into each other without loss of energy"
  parameter Parts.Mass m_1 = 1 "First cart";
  parameter Parts.Mass m_2 = 2 "Second cart";
  parameter Parts.Mass m_3 = 6 "Third cart";
  output Parts.Length x_1(start=0, fixed=true) "Place of the first cart";
  output Parts.Length x_2(start=1, fixed=true) "Place of the second cart";
  output Parts.Length x_3(start=3, fixed=true) "Place of the third cart";
  output Parts.Velocity v_1(start=1, fixed=true) "Speed of the first cart";
  output Parts.Velocity v_2(start=0, fixed=true) "Speed of the second cart";
  output Parts.Velocity v_3(start=0, fixed=true) "Speed of the third cart";
  output Integer hits(start=0, fixed=true) "Collisions so far";
equation
  v_1 = der(x_1);
  v_2 = der(x_2);
  v_3 = der(x_3);
  der(v_1) = 0;
  der(v_2) = 0;
  der(v_3) = 0;
  // momentum and energy stay
  when x_1 > x_2 then
    reinit(v_1, ((m_1 - m_2)*pre(v_1) + 2*m_2*pre(v_2))/(m_1 + m_2));
    reinit(v_2, ((m_2 - m_1)*pre(v_2) + 2*m_1*pre(v_1))/(m_1 + m_2));
  elsewhen x_2 > x_3 then
    reinit(v_2, ((m_2 - m_3)*pre(v_2) + 2*m_3*pre(v_3))/(m_2 + m_3));
    reinit(v_3, ((m_3 - m_2)*pre(v_3) + 2*m_2*pre(v_2))/(m_2 + m_3));
  end when;
  when {x_1 > x_2, x_2 > x_3} then
    hits = pre(hits) + 1;
  end when;
end Collisions;

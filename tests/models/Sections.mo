model Sections "Algorithm sections and when-clauses that the front end refuses as they stand"
  model Several "Several outputs, assigned more than once, with a loop, conditions and a function of two outputs"
    function polar "Two outputs"
      input Real r;
      input Real phi;
      output Real x;
      output Real y;
    algorithm
      x := r*cos(phi);
      y := r*sin(phi);
    end polar;
    Real x(start=1, fixed=true);
    output Real a "First";
    output Real b "Second";
    output Real c;
    output Real d;
    output Real m[2,3];
    output Real s;
    output Boolean late;
    output Integer n;
  algorithm
    a := 2*x "Twice";
    b := a + 1;
    // the order counts: b has the old a
    a := b + (if time > 0.5 then a else -a);
    (c, d) := polar(2, time);
    (, d) := polar(d, 0.5);
    s := 0;
    for i in 1:2 loop
      for j in i:3 loop
        m[i,j] := i*10 + j;
        s := s + m[i,j]*time;
      end for;
      for j in 1:i - 1 loop
        m[i,j] := -1;
      end for;
    end for;
  algorithm
    late := time > 0.6;
    if late and s > 50 then
      n := 1;
    elseif late then
      n := 2;
    else
      n := 3;
    end if;
  equation
    der(x) = 1;
  end Several;
  model Gain "A block whose algorithm has a variable of its own"
    input Real u;
    output Real y;
    parameter Real k = 1;
  protected
    Real a;
  algorithm
    a := k*u;
    y := a + 1;
  end Gain;
  model Chain "Blocks one after another, and an array of them"
    Gain first(k=2, u=time);
    Gain second(k=3, u=first.y);
    Gain more[2](k={10, 20}, u={time, 1});
    output Real y = second.y;
    output Real z = more[1].y + more[2].y;
  end Chain;
  model Partial "A variable that a branch leaves out has its start value"
    output Real y(start=3);
    output Real z;
  algorithm
    if time > 2 then
      y := 1;
    end if;
    z := 2*y;
  end Partial;
  model Buffer "A ring buffer: the index is known only when it runs"
    output Real v[4](each start=0, each fixed=true);
    output Real last(start=0, fixed=true);
    output Real total(start=0, fixed=true);
    output Integer k(start=0, fixed=true);
  algorithm
    when sample(0, 0.1) then
      k := mod(pre(k), 4) + 1;
      last := v[k];
      v[k] := time;
      total := 0;
      for i in 1:4 loop
        total := total + v[i];
      end for;
    end when;
  end Buffer;
  model Shift "A shift register, as an algorithm and as equations"
    output Real a[4](each start=0, each fixed=true);
    output Real b[4](each start=0, each fixed=true);
    output Real both(start=0, fixed=true);
  algorithm
    when sample(0, 0.1) then
      for i in 4:-1:2 loop
        a[i] := a[i-1];
      end for;
      a[1] := time;
    end when;
  equation
    when sample(0, 0.1) then
      b[1] = time;
      for i in 2:4 loop
        b[i] = pre(b[i-1]);
      end for;
    end when;
    when sample(0.05, 0.1) then
      both = a[2] - b[2];
    end when;
  end Shift;
  model Branches "elsewhen, if and reinit in the when-statement of an algorithm"
    Real x(start=1, fixed=true);
    output Integer n(start=0, fixed=true);
    output Real w(start=0, fixed=true);
    output Real y = x;
  algorithm
    when x < 0.5 then
      n := pre(n) + 1;
      w := 2*time;
      if n > 1 then
        reinit(x, w);
        n := n + 10;
      else
        reinit(x, 0.8);
      end if;
    elsewhen time > 0.9 then
      n := 100 + n;
    end when;
  equation
    der(x) = -1;
  end Branches;

  Several several "Several outputs";
  Chain chain "Blocks one after another";
  Partial partial_1 "Start values";
  Buffer buffer "A ring buffer";
  Shift shift "A shift register";
  Branches branches "elsewhen and reinit";
end Sections;

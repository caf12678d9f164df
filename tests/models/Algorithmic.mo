model Algorithmic "One small component for each piece of the language that computes step by step, and its like"
  model Functions "Functions: if, elseif, default and named arguments, nested calls, a local, return"
    function limited "Twice the argument, limited"
      input Real u;
      input Real most = 1;
      output Real y;
    protected
      Real a;
    algorithm
      a := 2*u;
      if a > most then
        y := most;
      elseif a < -most then
        y := -most;
      else
        y := a;
      end if;
    end limited;
    function early "Returns before the end"
      input Real u;
      output Real y;
    algorithm
      y := 0;
      if u > 1 then
        y := 1;
        return;
      end if;
      y := y + 2;
    end early;
    function nested "Calls others"
      input Real u;
      output Real y = 1;
    protected
      Real a = 2*u;
    algorithm
      y := y + limited(a, most=10) + early(u=3*a);
    end nested;
    output Real a = limited(time);
    output Real b = limited(-3*time, most=4);
    output Real c = nested(time);
    output Real d = early(time);
  end Functions;
  model FunctionLoops "Loops in functions, arrays whose size the argument gives"
    function polynomial "Horner's scheme"
      input Real c[:] "Coefficients, lowest first";
      input Real u;
      output Real y;
    algorithm
      y := 0;
      for i in size(c, 1):-1:1 loop
        y := y*u + c[i];
      end for;
    end polynomial;
    function transposed
      input Real A[:,:];
      output Real B[size(A, 2),size(A, 1)];
    algorithm
      for i in 1:size(A, 1) loop
        for j in 1:size(A, 2) loop
          B[j,i] := A[i,j];
        end for;
      end for;
    end transposed;
    function interpolated "Linear interpolation in a table"
      input Real x;
      input Real xs[:];
      input Real ys[size(xs, 1)];
      output Real y;
    algorithm
      y := ys[1];
      for i in 1:size(xs, 1) - 1 loop
        if x >= xs[i] then
          y := ys[i] + (ys[i+1] - ys[i])*(x - xs[i])/(xs[i+1] - xs[i]);
        end if;
      end for;
    end interpolated;
    function powers "As many powers as are asked for"
      input Real u;
      input Integer n;
      output Real y[n];
    protected
      Real p = 1;
    algorithm
      for i in 1:n loop
        p := p*u;
        y[i] := p;
      end for;
    end powers;
    parameter Real t[3] = {0, 0.5, 1};
    output Real a = polynomial({1, 2, 3}, time);
    output Real B[3,2] = transposed({{1, 2, 3}, {4, 5, time}});
    output Real c = interpolated(time, t, {0, 10, 5});
    output Real d[3] = powers(time, 3);
    output Real e[2] = abs(powers({-1, 2}*{time, time}, 2));
  end FunctionLoops;
  model FunctionOutputs "Several outputs, elementwise calls, a function in a parameter, a start value and a when-clause"
    function polar "Two outputs"
      input Real r;
      input Real phi;
      output Real x;
      output Real y;
    algorithm
      x := r*cos(phi);
      y := r*sin(phi);
    end polar;
    function quadrant "Uses the second output"
      input Real phi;
      output Real s;
    protected
      Real x;
      Real y;
    algorithm
      (x, y) := polar(1, phi);
      (, s) := polar(2, phi);
      s := s + x*y;
    end quadrant;
    function squared
      input Real u;
      output Real y;
    algorithm
      y := u^2;
    end squared;
    parameter Real k = 3;
    parameter Real p = squared(k);
    output Real a;
    output Real b;
    output Real c = quadrant(time);
    output Real d[2] = squared({2, time});
    output Real s(start=squared(p), fixed=true);
    output Real z(start=2, fixed=true);
    output Real q = p + polar(2, 0);
  equation
    (a, b) = polar(2, time);
    der(s) = 0;
    when sample(0, 0.5) then
      z = squared(pre(z));
    end when;
  end FunctionOutputs;
  model FunctionRecords "Records as arguments and results, constructors"
    record Phasor
      Real re;
      Real im;
    end Phasor;
    function product
      input Phasor a;
      input Phasor b;
      output Phasor c;
    algorithm
      c.re := a.re*b.re - a.im*b.im;
      c.im := a.re*b.im + a.im*b.re;
    end product;
    function conjugate
      input Phasor a;
      output Phasor c;
    algorithm
      c := Phasor(a.re, -a.im);
    end conjugate;
    Phasor p(re=time, im=1);
    Phasor q;
    Phasor r = conjugate(p);
    output Real a = q.re;
    output Real b = q.im;
    output Real c = r.im;
  equation
    q = product(p, conjugate(r));
  end FunctionRecords;
  model FunctionTypes "Boolean, Integer and enumeration in functions, a function given by redeclaration"
    type Mode = enumeration(off, slow, fast);
    function speed
      input Mode mode;
      input Boolean reverse;
      input Integer gear = 2;
      output Real w;
    algorithm
      if mode == Mode.off then
        w := 0;
      elseif mode == Mode.slow then
        w := gear;
      else
        w := 10*gear;
      end if;
      w := if reverse then -w else w;
    end speed;
    function beyond
      input Integer n;
      input Boolean really;
      output Boolean b;
    algorithm
      b := n > 1 and really;
    end beyond;
    partial function shape
      input Real u;
      output Real y;
    end shape;
    function cube
      extends shape;
    algorithm
      y := u^3;
    end cube;
    model Sender
      replaceable function f = shape;
      output Real y = f(time);
    end Sender;
    parameter Mode mode = Mode.fast;
    Sender sender(redeclare function f = cube);
    output Real a = speed(mode, true);
    output Boolean b;
    output Real c = sender.y;
    output Integer n(start=0, fixed=true);
  equation
    b = beyond(n, time > 0.5);
    when sample(0.1, 0.2) then
      n = pre(n) + 1;
    end when;
  end FunctionTypes;
  model FunctionChecks "assert in a function holds where the function is called; derivatives go through functions"
    function root
      input Real u;
      output Real y;
    algorithm
      assert(u >= 0, "root of a negative number");
      y := sqrt(u);
    end root;
    function area
      input Real r;
      output Real A;
    algorithm
      A := r^2;
    end area;
    Real r(start=1, fixed=true);
    Real A = area(r);
    output Real dA = der(A);
    output Real y;
  equation
    der(r) = 2;
    y = if time > 2 then root(time - 2) else 5;
  end FunctionChecks;
  model Algorithms "Algorithm sections outside when"
    output Real a;
    output Real b;
    output Real v[3];
    output Integer n;
    output Boolean late;
    output Integer up(start=0, fixed=true);
  algorithm
    if time > 0.5 then
      a := 1;
    else
      a := 2;
    end if;
  algorithm
    b := 0;
    for i in 1:3 loop
      v[i] := i*time;
      b := b + v[i];
    end for;
  algorithm
    late := time > 0.6;
  algorithm
    n := if late then 7 else 8;
  algorithm
    when late then
      up := pre(up) + n;
    end when;
  end Algorithms;
  model InitialAlgorithms "What initial algorithms and initial equations of discrete variables give"
    parameter Real k = 2;
    parameter Real p(fixed=false);
    parameter Real q = 2*p;
    discrete Real d;
    discrete Real e;
    Integer m;
    Real x[3];
    Real w;
    output Real a = q + m;
    output Real b = d + e;
    output Real c = x[1] + x[2] + x[3];
  initial algorithm
    p := 3*k;
    if p > 5 then
      m := 4;
    else
      m := 5;
    end if;
  initial equation
    d = 8;
    pre(e) = k;
    for i in 1:3 loop
      x[i] = i;
    end for;
    der(w) = 1;
    assert(w > 1, "w settles at 1.5");
  equation
    der(x) = {0, 0, 0};
    der(w) = 4 - 2*w;
    when time > 0.5 then
      d = pre(d)/2;
      e = pre(e)*10;
    end when;
    when time > 5 then
      m = 0;
    end when;
  end InitialAlgorithms;
  model Jumps "div, mod, rem, floor, ceil and integer of what varies: events at the jumps"
    output Real a = div(5*time - 2, 1);
    output Real b = mod(5*time - 2, 2);
    output Real c = rem(5*time - 2, 2);
    output Real d = floor(3*time - 2);
    output Integer e;
    output Real f = ceil(3*time);
    output Real g(start=0, fixed=true);
    output Real h = semiLinear(time - 0.5, 2, 3);
    output Real i = semiLinear(0.5 - time, 2, 3);
    output Real j = noEvent(mod(time, 0.3));
  equation
    e = integer(3*time);
    der(g) = div(5*time - 2.5, 1);
  end Jumps;
  model Initially "initial() in an equation, when with a Boolean array, a Boolean sampled"
    output Real y(start=0, fixed=true);
    output Integer n(start=0, fixed=true);
    output Integer m(start=0, fixed=true);
    Boolean b[2];
    Boolean s;
  equation
    der(y) = if initial() then 100 else 1;
    b = {time > 0.3, time > 0.6};
    s = sample(0, 0.25);
    when b then
      n = pre(n) + 1;
    end when;
    when s then
      m = pre(m) + 1;
    end when;
  end Initially;
  model Indices "Indices that are known only when it runs, and sizes that follow from parameters"
    type Mode = enumeration(off, slow, fast);
    parameter Real k[Mode] = {1, 2, 3};
    parameter Mode mode = Mode.slow;
    parameter Integer n = 3;
    parameter Real A[2,3] = {{1, 2, 3}, {4, 5, 6}};
    Integer i(start=1, fixed=true);
    output Real a = k[mode];
    output Real b = A[2,i];
    output Real c = A[i,:]*{1, 10, 100};
    output Real d = sum(j*time for j in 1:n);
    output Real e = A[2,n];
  equation
    when time > 0.5 then
      i = pre(i) + 1;
    end when;
  end Indices;
  model Momentum "Derivatives of expressions: a cart that loses sand, which leaves at rest"
    output Real m(start=10, fixed=true);
    output Real v(start=2, fixed=true);
    Real x(start=1, fixed=true);
    output Real a = der(x*x);
    output Real b = der(der(x*x*x));
    output Real c = der(sin(x)*exp(x));
  equation
    der(m) = -0.5;
    der(m*v) = 3;
    der(x) = 1;
  end Momentum;
  model Oscillator "A second derivative"
    output Real x(start=1, fixed=true);
  initial equation
    der(x) = 0;
  equation
    der(der(x)) = -4*x;
  end Oscillator;
  model Enumerations "Numbers of enumeration literals"
    type Gear = enumeration(low, high);
    parameter Gear gear = Gear.high;
    output Integer n = Integer(gear);
    output Boolean b = gear > Gear.low;
  end Enumerations;
  model Redeclared "Components that differ in a class, in their sizes and in what a parameter decides"
    partial model Source
      Real y;
    end Source;
    model Slow
      extends Source;
      parameter Real k = 1;
    equation
      y = k*time;
    end Slow;
    model Fast
      extends Source;
      parameter Real k = 1;
      parameter Real q = 10;
    equation
      y = k*q*time;
    end Fast;
    model Faster = Fast(k=7);
    model Holder
      replaceable model Part = Slow constrainedby Source;
      parameter Integer n = 2;
      parameter Integer kind = 1;
      Part part;
      Real x[n];
      output Real s = sum(x) + part.y;
    equation
      for i in 1:n loop
        x[i] = i*time;
      end for;
      if kind == 1 then
        connection = 1;
      elseif kind == 2 then
        connection = 2;
      else
        connection = 3;
      end if;
    public
      output Real connection;
    end Holder;
    Holder a;
    Holder b(redeclare model Part = Faster, n=3, kind=2);
    Holder c(n=4, kind=3, part(k=5));
  end Redeclared;
  model Shapes "Matrices with one row or column, powers, symmetric parts"
    Real a[2,1] = {{1}, {time}};
    Real b[1,2] = transpose(a);
    output Real c[2,2] = a*b;
    output Real d[1,1] = b*a;
    output Real v[2] = a[:,1];
    output Real w[2] = c[1,:] + v;
    output Real e[2] = c*v;
    output Real m[1] = b*v;
    output Real p[2,2] = {{1, 2}, {3, 4}}^2;
    output Real s[2,2] = outerProduct({1.0, 2.0}, {3.0, time});
    output Real r[3,3] = skew({1.0, 2.0, time});
    output Real q[2] = vector(a);
    output Real u[2,2] = cat(1, {{1, time}}, {{3, 4}});
    output Real z[2,3] = cat(2, {{1}, {2}}, {{3, 4}, {5, time}});
  end Shapes;

  Functions functions "Functions: if, elseif, default and named arguments, nested calls, a local, return";
  FunctionLoops functionLoops "Loops in functions, arrays whose size the argument gives";
  FunctionOutputs functionOutputs "Several outputs, elementwise calls, a function in a parameter, a start value and a when-clause";
  FunctionRecords functionRecords "Records as arguments and results, constructors";
  FunctionTypes functionTypes "Boolean, Integer and enumeration in functions, a function given by redeclaration";
  FunctionChecks functionChecks "assert in a function holds where the function is called; derivatives go through functions";
  Algorithms algorithms "Algorithm sections outside when";
  InitialAlgorithms initialAlgorithms "What initial algorithms and initial equations of discrete variables give";
  Jumps jumps "div, mod, rem, floor, ceil and integer of what varies: events at the jumps";
  Initially initially "initial() in an equation, when with a Boolean array, a Boolean sampled";
  Indices indices "Indices that are known only when it runs, and sizes that follow from parameters";
  Momentum momentum "Derivatives of expressions";
  Oscillator oscillator "A second derivative";
  Enumerations enumerations "Numbers of enumeration literals";
  Redeclared redeclared "Components that differ in more than values";
  Shapes shapes "Matrices with one row or column, powers, symmetric parts";
end Algorithmic;

model Language "One small component for each piece of the language; the tests know what each must give"
  model IntPar "Arithmetic of integer parameters"
    parameter Integer n=7;
    parameter Integer a=div(n,2);
    parameter Integer b=mod(-n,3);
    parameter Integer c=rem(-n,3);
    parameter Real d=floor(-2.5);
    parameter Integer e=integer(2.7);
    parameter Real f=ceil(2.1);
    parameter Real g = if n > 5 and not n == 6 then 1 else 2;
    parameter Boolean h = n <> 7 or n >= 7;
    parameter Real i = n/2;
    output Real y;
  equation
    y = a+b+c;
  end IntPar;
  model Elsewhen "The first branch of a when-clause that becomes true acts"
    output Integer k(start=0,fixed=true);
    Real x(start=0,fixed=true);
  equation
    der(x)=1;
    when x>0.3 then k=pre(k)+1;
    elsewhen x>0.2 then k=pre(k)+10;
    elsewhen {x>0.5,x>0.6} then k=pre(k)+100;
    end when;
  end Elsewhen;
  model InitialWhen "initial() makes a when-clause act at the start"
    output Integer k(start=0,fixed=true);
    output Real q(start=1,fixed=true);
    Real x(start=0,fixed=true);
  equation
    der(x)=1;
    when initial() then k=pre(k)+1;
    end when;
    when {initial(), x>0.5} then
      q = pre(q)*2;
    end when;
  end InitialWhen;
  model EdgeChange "edge() and change()"
    output Integer up(start=0,fixed=true);
    output Integer ch(start=0,fixed=true);
    Boolean b;
    Real x(start=0,fixed=true);
  equation
    der(x)=1;
    b = sin(20*x)>0;
    when edge(b) then up=pre(up)+1;
    end when;
    when change(b) then ch=pre(ch)+1;
    end when;
  end EdgeChange;
  model IfEq "if-equations"
    parameter Boolean p=true;
    output Real y;
    output Real z;
    Real x(start=0,fixed=true);
  equation
    der(x)=1;
    if p then y=x;
    else y=-x;
    end if;
    if x>0.5 then z=1;
    elseif x>0.2 then z=2;
    else z=3;
    end if;
  end IfEq;
  model Mat "Matrices and vectors"
    parameter Real A[2,2]={{1,2},{3,4}};
    parameter Real B[2,3]=[1,2,3; 4,5,6];
    output Real x[2](start={1,2},each fixed=true);
    output Real d;
    output Real s;
    output Real t[2];
    output Real u[2];
    output Real w;
    output Real c[2];
    output Real m[3];
    output Real n;
    output Real o[2];
  equation
    der(x)={0,0};
    d=x*x;
    s=sum(A)+min(A)+max(B)+product(x);
    t=A*x;
    u=transpose(A)*x;
    w=x*A[1,:];
    c=A[:,2]+x;
    m=x*B;
    n=size(B,2);
    o = A[2,:] .* x + 2*x;
  end Mat;
  model MatState "A matrix of states"
    output Real P[2,2](start={{1,2},{3,4}}, each fixed=true);
    parameter Real A[2,2]={{0,1},{0,0}};
  equation
    der(P)=A*P;
  end MatState;
  model DerWhen "A derivative read at an event"
    output Real v(start=0,fixed=true);
    output Boolean b;
    Real x(start=0,fixed=true);
  equation
    der(x)=2*time;
    b = der(x) > 1;
    when sample(0.25,1) then v=der(x);
    end when;
  end DerWhen;
  model TimeWhen "An event at a time"
    output Real v(start=0,fixed=true);
  equation
    when time>=0.5 then v=time;
    end when;
  end TimeWhen;
  model TwoClocks "Two clocks that tick together"
    output Integer a(start=0,fixed=true);
    output Integer b(start=0,fixed=true);
  equation
    when sample(0,0.1) then a=pre(a)+1;
    end when;
    when sample(0.05,0.2) then b=pre(b)+a;
    end when;
  end TwoClocks;
  model Reinit2 "Two states reset at once"
    output Real x(start=1,fixed=true);
    output Real y(start=0,fixed=true);
  equation
    der(x)=-1;
    der(y)=1;
    when x<0.5 then
      reinit(x,pre(x)+1);
      reinit(y, -y);
    end when;
  end Reinit2;
  model Cond "A conditional component"
    model R parameter Real k=2;
      output Real y;
  equation
      y=k*time;
    end R;
    parameter Boolean on=true;
    R r if on;
    R s(k=5);
    output Real z;
  equation
    z=s.y;
  end Cond;
  model InnerOuter "inner and outer"
    model W parameter Real g=9;
    end W;
    model U outer W w;
      output Real y;
  equation
      y=w.g*time;
    end U;
    inner W w(g=3);
    U u;
    output Real z=u.y;
  end InnerOuter;
  model Rec "A record"
    record Rc Real a;
      Real b;
    end Rc;
    Rc r;
    output Real z;
  equation
    r.a=time;
    r.b=2*r.a;
    z=r.a+r.b;
  end Rec;
  model RecPar "A record of parameters"
    record Rc parameter Real a=1;
      parameter Real b=2;
    end Rc;
    parameter Rc r(a=5);
    output Real z;
  equation
    z=r.a+r.b;
  end RecPar;
  model Replace "extends and replaceable with modification"
    model B parameter Real k=1;
      output Real y;
  equation
      y=k;
    end B;
    model D extends B(k=4);
    end D;
    replaceable model T=B;
    T t(k=7);
    D d;
    output Real z=t.y+d.y;
  end Replace;
  model Conn "Signal connectors"
    connector I=input Real;
    connector O=output Real;
    block G I u;
      O y;
      parameter Real k=2;
  equation
      y=k*u;
    end G;
    G a;
    G b(k=3);
    output Real z;
  equation
    a.u=time;
    connect(a.y,b.u);
    z=b.y;
  end Conn;
  model Homotopy "homotopy() and smooth()"
    output Real y;
    output Real z;
  equation
    y=homotopy(time, 3);
    z=smooth(1, if time>0.5 then (time-0.5)^2 else 0);
  end Homotopy;
  model Alg2 "A nonlinear equation"
    output Real x(start=1);
  equation
    x^3 + x = 2*time+2;
  end Alg2;
  model NonlinPair "Two nonlinear equations"
    output Real x(start=2);
    output Real y(start=0.5);
  equation
    x^2+y^2=4+time;
    x*y=1;
  end NonlinPair;
  model LinLoop "A linear system"
    output Real a;
    output Real b;
    output Real c;
    output Real d;
    output Real e;
  equation
    2*a+b=time;
    a+3*b+c=1;
    b+4*c+d=2;
    c+5*d+e=3;
    d+6*e=4;
  end LinLoop;
  model BoolEq "Boolean equations"
    Boolean a;
    Boolean b;
    output Boolean c;
    Real x(start=0,fixed=true);
  equation
    der(x)=1;
    b=not a;
    a=x>0.5;
    c = a or b and not a;
  end BoolEq;
  model AlgWhen "An algorithm that assigns twice, and pre() in it"
    output Real s(start=0,fixed=true);
    output Real last(start=0,fixed=true);
    Real x(start=0,fixed=true);
  algorithm
    when sample(0.1,0.2) then
      s := s + x;
      s := 2*s;
      last := s - pre(s);
    end when;
  equation
    der(x)=1;
  end AlgWhen;
  model MinMax "min() and max()"
    output Real y;
    output Real z;
    parameter Real v[4]={3,1,4,1.5};
  equation
    y=max({time,0.2,0.7});
    z=min(v)+max(v);
  end MinMax;
  model Abs "abs() and sign()"
    output Real x(start=1,fixed=true);
  equation
    der(x)=-2*sign(x-0.5)*0 - abs(x);
  end Abs;
  model NegAlias "Variables that are equal but for the sign"
    output Real x(start=1,fixed=true);
    output Real y;
    output Real w;
  equation
    y=-x;
    der(x)=-w;
    w=-y*1;
  end NegAlias;
  model Ident "Array constructors"
    parameter Real A[2,2]=identity(2);
    parameter Real d[2]=linspace(1,2,2);
    parameter Real f[3]=fill(2,3);
    parameter Real z[2,2]=zeros(2,2);
    parameter Real D[2,2]=diagonal({1,2});
    output Real y=A[1,1]+d[2]+f[3]+z[1,2]+D[2,2];
  end Ident;
  model Cross "Products of vectors"
    parameter Real a[3]={1,0,0};
    parameter Real b[3]={0,1,0};
    output Real c[3]=cross(a,b);
    output Real n = a*b;
  end Cross;
  model ArrComp "Array comprehension and sum over an iterator"
    parameter Real v[3]={i^2 for i in 1:3};
    output Real s=sum(v[i]*i for i in 1:3);
  end ArrComp;
  model End "end in subscripts"
    parameter Real v[3]={1,2,3};
    output Real s=v[end]+v[end-1];
    output Real t = sum(v[2:end]);
  end End;
  model DiscReal "A discrete Real in a continuous equation"
    discrete output Real d(start=2,fixed=true);
    Real x(start=0,fixed=true);
  equation
    der(x)=d;
    when x>0.5 then d=pre(d)/2;
    end when;
  end DiscReal;
  model Assign "Two variables in both branches of a when-clause"
    output Integer n(start=0,fixed=true);
    output Boolean f(start=false,fixed=true);
  equation
    when time>0.3 then n=pre(n)+1;
    f=true;
    elsewhen time>0.6 then n=pre(n)+10;
    f=false;
    end when;
  end Assign;
  model Exp "Operators and functions"
    output Real a=2^3;
    output Real b=-2^2;
    output Real c=1e-3/2*4;
    output Real d=7-3-2;
    output Real e=2/4/2;
    output Real g=exp(1)+log10(100)+log(1);
    output Real h = atan2(1,1)+asin(1)+tanh(0);
  end Exp;
  model ParamEq "Parameters that follow from parameters"
    parameter Real a=2;
    final parameter Real b=3*a;
    parameter Real c(min=0)=b+1;
    constant Real k=c0;
    constant Real c0=5;
    output Real y=b+c+k;
  end ParamEq;
  model NestedIfWhen "if inside when"
    output Integer n(start=0,fixed=true);
    Real x(start=0,fixed=true);
  equation
    der(x)=1;
    when sample(0,0.1) then
      if x > 0.55 then n=pre(n)+100;
    elseif x>0.25 then n=pre(n)+10;
    else n=pre(n)+1;
    end if;
    end when;
  end NestedIfWhen;
  model PreInput "An input sampled"
    input Real u(start=1);
    output Real s(start=0,fixed=true);
  equation
    when sample(0,0.5) then s=pre(s)+u;
    end when;
  end PreInput;
  model NoEvt "noEvent()"
    output Real x(start=0,fixed=true);
  equation
    der(x)=if noEvent(x<0.5) then 1 else 1;
  end NoEvt;
  model Delayed "pre() of a variable that changes at the same event"
    output Boolean a(start=false,fixed=true);
    output Boolean b(start=false,fixed=true);
  equation
    when sample(0,0.3) then a=not pre(a);
    b=pre(a);
    end when;
  end Delayed;
  model WhenChain "An event that causes another"
    output Integer n(start=0,fixed=true);
    output Integer m(start=0,fixed=true);
  equation
    when time>0.5 then n=pre(n)+1;
    end when;
    when n>0 then m=pre(m)+1;
    end when;
  end WhenChain;

  IntPar intPar "Arithmetic of integer parameters";
  Elsewhen elsewhen_1 "The first branch of a when-clause that becomes true acts";
  InitialWhen initialWhen "initial() makes a when-clause act at the start";
  EdgeChange edgeChange "edge() and change()";
  IfEq ifEq "if-equations";
  Mat mat "Matrices and vectors";
  MatState matState "A matrix of states";
  DerWhen derWhen "A derivative read at an event";
  TimeWhen timeWhen "An event at a time";
  TwoClocks twoClocks "Two clocks that tick together";
  Reinit2 reinit2 "Two states reset at once";
  Cond conditional "A conditional component";
  InnerOuter innerOuter "inner and outer";
  Rec record_1 "A record";
  RecPar recPar "A record of parameters";
  Replace replace_1 "extends and replaceable with modification";
  Conn connected "Signal connectors";
  Homotopy homotopy_1 "homotopy() and smooth()";
  Alg2 alg2 "A nonlinear equation";
  NonlinPair nonlinPair "Two nonlinear equations";
  LinLoop linLoop "A linear system";
  BoolEq boolEq "Boolean equations";
  AlgWhen algWhen "An algorithm that assigns twice, and pre() in it";
  MinMax minMax "min() and max()";
  Abs absolute "abs() and sign()";
  NegAlias negAlias "Variables that are equal but for the sign";
  Ident ident "Array constructors";
  Cross crossed "Products of vectors";
  ArrComp arrComp "Array comprehension and sum over an iterator";
  End ends "end in subscripts";
  DiscReal discReal "A discrete Real in a continuous equation";
  Assign assigned "Two variables in both branches of a when-clause";
  Exp functions "Operators and functions";
  ParamEq paramEq "Parameters that follow from parameters";
  NestedIfWhen nestedIfWhen "if inside when";
  PreInput preInput(u=1) "An input sampled";
  NoEvt noEvt "noEvent()";
  Delayed delayed "pre() of a variable that changes at the same event";
  WhenChain whenChain "An event that causes another";
end Language;

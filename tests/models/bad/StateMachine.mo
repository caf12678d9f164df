model StateMachine "A state machine of Modelica 3.3"
  block Count "The only state"
    outer Integer n "Count";
  equation
    n = previous(n) + 1;
  end Count;
  inner Integer n(start=0) "Count";
  Count count "The only state";
equation
  initialState(count);
end StateMachine;

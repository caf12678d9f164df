within Small;
model Lights "Traffic lights: a state machine in an algorithm section"
  type Colour = enumeration(red "Stop", green "Go", amber "Wait") "Colour of the light";
  input Boolean request(start=false) "A pedestrian has pressed the button";
  output Colour colour(start=Colour.green, fixed=true) "Colour";
  output Integer count(start=0, fixed=true) "Ticks in this colour";
  output Integer changes(start=0, fixed=true) "Changes so far";
  parameter Integer n_amber = 2 "Ticks of amber";
  parameter Integer n_red = 3 "Ticks of red";
algorithm
  when sample(0, 0.5) then
    count := pre(count) + 1;
    if pre(colour) == Colour.green then
      if request then
        colour := Colour.amber;
        count := 0;
      end if;
    elseif pre(colour) == Colour.amber and count >= n_amber then
      colour := Colour.red;
      count := 0;
    elseif pre(colour) == Colour.red and count >= n_red then
      colour := Colour.green;
      count := 0;
    end if;
    if count == 0 then
      changes := pre(changes) + 1;
    end if;
  end when;
end Lights;

model ThreeDimensions "An array with three dimensions"
  Real t[2,2,2](each unit="1") "Tensor";
equation
  for i in 1:2 loop
    for j in 1:2 loop
      for k in 1:2 loop
        t[i,j,k] = i*j*k*time;
      end for;
    end for;
  end for;
end ThreeDimensions;

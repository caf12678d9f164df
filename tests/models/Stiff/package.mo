package Stiff "Stiff problems of which the solution at the end is published; each class names its source"
  annotation(Documentation(info="
    The problems and their reference solutions are those of the Test Set for Initial Value Problem Solvers,
    F. Mazzia, C. Magherini, University of Bari, release 2.4 (2008), called 'test set' here; most are discussed in
    E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer 1996, called 'HW' here.
    Amounts of substance are scaled to the unit 1, as in the sources. A nominal is the size below which a component
    does not matter: the absolute tolerance is the relative one times it."));
end Stiff;

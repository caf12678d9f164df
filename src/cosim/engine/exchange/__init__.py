"""FMUs for Model Exchange, given a solver so that they step as those for Co-Simulation do."""

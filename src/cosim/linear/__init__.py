"""Linear models: A, B, C, D of a Modelica model at an operating point, from the exact derivatives of its equations."""

from cosim.linear._bode import bode
from cosim.linear._equations import symbols_behind
from cosim.linear._linearize import Linearizer, linearize
from cosim.linear._operating_point import Observed, observed
from cosim.linear._system import LinearSystem, Pole, Signal

__all__ = [
    "LinearSystem",
    "Linearizer",
    "Observed",
    "Pole",
    "Signal",
    "bode",
    "linearize",
    "observed",
    "symbols_behind",
]

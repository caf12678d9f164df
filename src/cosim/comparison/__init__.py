"""Compares runs with measurements: alignment, figures of the difference, a tube that gives a verdict."""

from cosim.comparison._alignment import Alignment
from cosim.comparison._compare import Comparison, Revolutions, compare, figure_names
from cosim.comparison._curve import Curve, Pair, on_one_grid
from cosim.comparison._measures import Spectrum
from cosim.comparison._options import OF_THE_QUANTITY, SIGNALS, Options, Quantity
from cosim.comparison._plot import draw
from cosim.comparison._tube import Tube, tube

__all__ = [
    "OF_THE_QUANTITY",
    "SIGNALS",
    "Alignment",
    "Comparison",
    "Curve",
    "Options",
    "Pair",
    "Quantity",
    "Revolutions",
    "Spectrum",
    "Tube",
    "compare",
    "draw",
    "figure_names",
    "on_one_grid",
    "tube",
]

"""Fits parameters of the drive to measurements."""

from cosim.calibration._data import Data, data_of
from cosim.calibration._file import write_fit
from cosim.calibration._fit import Method, fit
from cosim.calibration._model import Model, linkage_equations, linkage_model, linkage_plant
from cosim.calibration._plot import draw_fit
from cosim.calibration._problem import Free
from cosim.calibration._progress import Progress
from cosim.calibration._results import Agreement, Estimate, Fit
from cosim.calibration._uncertainty import Direction, Uncertainty

__all__ = [
    "Agreement",
    "Data",
    "Direction",
    "Estimate",
    "Fit",
    "Free",
    "Method",
    "Model",
    "Progress",
    "Uncertainty",
    "data_of",
    "draw_fit",
    "fit",
    "linkage_equations",
    "linkage_model",
    "linkage_plant",
    "write_fit",
]

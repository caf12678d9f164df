"""Measured torque: one form for the supplier's workbooks, the source script's .mat files, CSV and MDF."""

from cosim.measurement._measurement import COLUMNS, Measurement, Meta
from cosim.measurement._processing import (
    Onset,
    Smoothing,
    correlation_onset,
    find_onset,
    moving_average,
    smooth,
    threshold_onset,
    zero_phase,
)
from cosim.measurement._read import read

__all__ = [
    "COLUMNS",
    "Measurement",
    "Meta",
    "Onset",
    "Smoothing",
    "correlation_onset",
    "find_onset",
    "moving_average",
    "read",
    "smooth",
    "threshold_onset",
    "zero_phase",
]

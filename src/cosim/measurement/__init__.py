"""Measured torque: one form for the supplier's workbooks, the source script's .mat files, CSV and MDF."""

from cosim.measurement._inspect import Inspection, draw_smoothing, inspect
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
from cosim.measurement._synthesize import CONDITIONS, Conditions, Errors, synthesize

__all__ = [
    "COLUMNS",
    "CONDITIONS",
    "Conditions",
    "Errors",
    "Inspection",
    "Measurement",
    "Meta",
    "Onset",
    "Smoothing",
    "correlation_onset",
    "draw_smoothing",
    "find_onset",
    "inspect",
    "moving_average",
    "read",
    "smooth",
    "synthesize",
    "threshold_onset",
    "zero_phase",
]

"""Judges runs: the thesis's criteria for the voltage profile, vibration measures, and their comparison."""

from cosim.assessment._comparison import Comparison, compare
from cosim.assessment._method import Method
from cosim.assessment._rules import Rules
from cosim.assessment._sampled import spectrum
from cosim.assessment._score import LOOKED_AT, score
from cosim.assessment._trace import Trace, trace
from cosim.assessment._verdict import Counts, Failure, Revolution, Score
from cosim.assessment._vibration import MEASURED, Measure, Vibration, vibration

__all__ = [
    "LOOKED_AT",
    "MEASURED",
    "Comparison",
    "Counts",
    "Failure",
    "Measure",
    "Method",
    "Revolution",
    "Rules",
    "Score",
    "Trace",
    "Vibration",
    "compare",
    "score",
    "spectrum",
    "trace",
    "vibration",
]

"""Judges a run: the thesis's criteria for the voltage profile."""

from cosim.assessment._rules import Rules
from cosim.assessment._score import score
from cosim.assessment._trace import Trace, trace
from cosim.assessment._verdict import Counts, Failure, Revolution, Score

__all__ = ["Counts", "Failure", "Revolution", "Rules", "Score", "Trace", "score", "trace"]

"""From Modelica text to one flat model: variables, equations, when-clauses, each with its place in the text."""

from cosim.modelica.dimensions import UnitMismatch, check_units, refuse_mismatches
from cosim.modelica.flat import FlatModel
from cosim.modelica.frontend import flatten
from cosim.modelica.source import Source

__all__ = ["FlatModel", "Source", "UnitMismatch", "check_units", "flatten", "refuse_mismatches"]

"""From Modelica text to one flat model: variables, equations, when-clauses, each with its place in the text."""

from cosim.modelica.flat import FlatModel
from cosim.modelica.frontend import flatten
from cosim.modelica.source import Source

__all__ = ["FlatModel", "Source", "flatten"]

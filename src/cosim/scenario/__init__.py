"""Scenario files: what is simulated, for how long, and what drives it; a CSV table becomes the engine's system."""

from cosim.scenario._assemble import Locate, ScenarioWarning, assemble
from cosim.scenario._model import Column, Link, Scenario, Setting
from cosim.scenario._read import read

__all__ = ["Column", "Link", "Locate", "Scenario", "ScenarioWarning", "Setting", "assemble", "read"]

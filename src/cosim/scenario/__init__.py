"""Scenario files: what is simulated, for how long, and what drives it; a CSV table becomes the engine's system.

A file has ``# key: value`` lines, a header, and rows::

    # title: Braked once
    # system: linkage                           a built-in plant, or the path of an .fmu from the file's folder
    # controller: voltage_profile               a built-in controller, the path of an .fmu, or none
    # stop: 25 s                                default: the last row's time
    # sample_time: 20 ms                        becomes the controller's T_sample; default 20 ms
    # set: plant.ext_load = 4 N.m               repeatable
    # map: plant.i_motor -> controller.current  repeatable; other inputs are connected by name
    # linear: v_supply                          these columns are interpolated, all others hold
    # fault: i_motor bias 0.5 A from 2 s to 5 s repeatable, see docs/faults.md
    ## a comment: two number signs
    time [s],tau_disturbance [N.m],v_supply [V]
    0,0,28
    3,-5,
    3.3,0,24

Decisions where the format leaves a choice: without channels the header ``time [s]`` suffices, rows are not needed. An
empty cell says nothing about its channel, so a linear channel is interpolated across it. A column without any value is
refused, it would do nothing. A ``#`` line without a colon is a comment unless it looks like a key. A bare number has
the unit 1. The column in a message is the cell's number in its row.
"""

from cosim.scenario._assemble import Locate, assemble
from cosim.scenario._model import Column, FaultLine, Link, Scenario, ScenarioWarning, Setting
from cosim.scenario._read import read
from cosim.scenario._values import parameter_value
from cosim.scenario.parameter_file import read_parameters, write_parameters

__all__ = [
    "Column",
    "FaultLine",
    "Link",
    "Locate",
    "Scenario",
    "ScenarioWarning",
    "Setting",
    "assemble",
    "parameter_value",
    "read",
    "read_parameters",
    "write_parameters",
]

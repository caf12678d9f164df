"""Co-simulation of FMUs: sampled components act at their own instants, without delay; the others run in between."""

from cosim.engine._branches import Branches, branches, warm_up
from cosim.engine._coupling_error import EXACT
from cosim.engine._explain import explain_timing
from cosim.engine._isolation import Isolate
from cosim.engine._result import PartialResultError, Result, SimulationInterrupted
from cosim.engine._simulate import simulate
from cosim.engine.checkpoints._checkpoint import Checkpoint
from cosim.engine.fmu._fmu import Fmu, Interface
from cosim.engine.fmu._variable import Value, Variable
from cosim.engine.system._arguments import LEAST_TOLERANCE
from cosim.engine.system._connection import Connection
from cosim.engine.system._fault import FOR_ALL_TYPES as FAULTS_FOR_ALL_TYPES
from cosim.engine.system._fault import KINDS as FAULT_KINDS
from cosim.engine.system._fault import RANDOM as RANDOM_FAULTS
from cosim.engine.system._fault import Fault, FaultKind, described
from cosim.engine.system._method import Algorithm
from cosim.engine.system._power import PowerConnection
from cosim.engine.system._role import Role, role_of
from cosim.engine.system._system import Channel, Component, System

__all__ = [
    "EXACT",
    "FAULTS_FOR_ALL_TYPES",
    "FAULT_KINDS",
    "LEAST_TOLERANCE",
    "RANDOM_FAULTS",
    "Algorithm",
    "Branches",
    "Channel",
    "Checkpoint",
    "Component",
    "Connection",
    "Fault",
    "FaultKind",
    "Fmu",
    "Interface",
    "Isolate",
    "PartialResultError",
    "PowerConnection",
    "Result",
    "Role",
    "SimulationInterrupted",
    "System",
    "Value",
    "Variable",
    "branches",
    "described",
    "explain_timing",
    "role_of",
    "simulate",
    "warm_up",
]

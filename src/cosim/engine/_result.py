"""What a simulation returns, and the errors that carry what was computed before it ended."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cosim.engine.checkpoints._checkpoint import Checkpoint
from cosim.engine.system._fault import Fault
from cosim.errors import SimulationError


@dataclass
class Result:
    """Trajectories on the output grid.

    ``time`` [s] has shape (n,): the multiples of the output interval, and stop as the last. ``columns`` maps
    "component.variable" to an array of shape (n,), in the order of the components: all their outputs, then the inputs
    that channels drive, and those with faults, as the components get them; float64 for Real, int64 for the other types
    (a Boolean is 0 or 1). ``units`` holds the FMI unit of the columns that have one, ``literals`` the names of an
    enumeration's values 1, 2, ..., ``faults`` what was done on purpose, with the periods that were chosen.

    A row holds the values after the events at its time; an output of a continuous component holds the end of the step
    that led there, before those events act on it.

    ``statistics``: ``wall_s`` [s] of the loop; ``loop``, "native" or "python"; ``exchanges``, the number of instants at
    which values were handed over; by component ``roles``, ``steps`` (doStep calls), ``events`` (instants with an event,
    event-mode components) and ``solver`` (the counters that the FMU publishes as ``solver.*``); ``coupling``, a list
    with an entry for each connection, and ``second_wall_s`` of the run behind its estimates, if there was one.

    An entry of ``coupling`` has ``source``, ``target``, ``delay_s``, the longest time [s] between the instant for which
    a value is put out and that from which it acts (None: unknown), ``error``, the estimated largest error of the
    source's signal in its ``unit``, ``relative``, that as a share of the signal's range, ``order``, the power of the
    interval between communication points with which the error falls, and ``target_outputs``, the output of the target
    that is off most. ``error`` is None where ``note`` says that there is none, or why it is not known.

    Where a system has power connections, ``power`` has an entry for each: ``effort``, ``flow``, ``given_J`` and
    ``taken_J``, the energies [J] that one side has given and the other has taken, ``error_J``, the difference, which
    the coupling has added, ``exchanged_J``, the integral of the power without its sign, ``relative``, the error as a
    share of that, and ``note``, for what is approximate or not measured.

    After a resumed run ``resumed_at_s`` [s] tells from where, all other counts are from 0 on, and ``wall_s`` is that of
    the rest. ``checkpoints`` are those that ``simulate`` was asked for, as far as it came.
    """

    time: NDArray[np.float64]
    columns: dict[str, NDArray[np.float64] | NDArray[np.int64]]
    units: dict[str, str] = field(default_factory=dict)
    literals: dict[str, tuple[str, ...]] = field(default_factory=dict)
    statistics: dict[str, object] = field(default_factory=dict)
    complete: bool = True
    message: str | None = None
    faults: tuple[Fault, ...] = ()
    checkpoints: tuple[Checkpoint, ...] = ()


class PartialResultError(SimulationError):
    """A simulation that could not be finished; ``result`` holds the rows before the failure."""

    def __init__(self, message: str, result: Result) -> None:
        """Keep the message and the partial result."""
        super().__init__(message)
        self.result = result


class SimulationInterrupted(KeyboardInterrupt):
    """Ctrl-C during a simulation; ``result`` holds the rows up to then."""

    def __init__(self, message: str, result: Result) -> None:
        """Keep the message and the partial result."""
        super().__init__(message)
        self.result = result

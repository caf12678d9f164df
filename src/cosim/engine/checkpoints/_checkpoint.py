"""A checkpoint: all that is needed to go on from a communication point as if nothing had happened."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cosim.engine.checkpoints._checkpoint_file import Contents, read, write
from cosim.engine.checkpoints._snapshot import Snapshot
from cosim.engine.loop._setup import Setup


@dataclass(frozen=True, eq=False, repr=False)
class Checkpoint:
    """The state of a whole run at ``time`` [s], a communication point, after its events.

    ``rows``, shape (number, recorded signals), are those recorded so far. ``setup`` is what
    was simulated, ``snapshot`` what the engine remembers, ``states`` what each FMU has written down of itself.
    """

    setup: Setup
    snapshot: Snapshot
    states: tuple[bytes, ...]
    rows: NDArray[np.float64]

    def __repr__(self) -> str:
        """Return what it is of, and where."""
        names = ", ".join(used.name for used in self.setup.components)
        return f"<checkpoint of {names} at {self.time:.9g} s, with {len(self.rows)} rows>"

    @property
    def time(self) -> float:
        """Where it is [s]."""
        return self.snapshot.time

    @property
    def horizon(self) -> float:
        """Up to where [s] a run may go on from here: the stop time that the FMUs were told, infinite if none."""
        return self.setup.horizon

    def save(self, path: Path | str) -> Path:
        """Write it to a file, which is complete or not there, whatever happens; return its path.

        Raises InputError if it cannot be written.
        """
        return write(Contents(self.setup, self.snapshot, self.states, self.rows), Path(path))

    @classmethod
    def load(cls, path: Path | str) -> Checkpoint:
        """Read a file that ``save`` has written; raises InputError for any other, or a damaged one."""
        return cls(*read(Path(path)))

    @staticmethod
    def file_name(at: float) -> str:
        """Return the name of the file that ``simulate`` writes for the time ``at`` [s]: "checkpoint_2.5s.cosim"."""
        return f"checkpoint_{at:.9g}s.cosim"

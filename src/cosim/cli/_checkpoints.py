"""Options of ``cosim run`` for checkpoints: where to make some, and from which one to go on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypedDict

from cosim.cli._times import time_of
from cosim.engine import Checkpoint, Result
from cosim.errors import InputError


class Arguments(TypedDict, total=False):
    """Those of ``simulate``."""

    checkpoint_at: Sequence[float]
    checkpoint_to: Path
    resume: Checkpoint


@dataclass(frozen=True)
class Checkpoints:
    """Times [s] at which to make one, and the file of the one to go on from."""

    at: tuple[float, ...] = ()
    resume: Path | None = None

    @classmethod
    def of(cls, times: Sequence[str] | None, resume: Path | None, scenarios: int) -> Checkpoints:
        """Read the options for a number of scenarios; raises `InputError`."""
        if resume is not None and scenarios > 1:
            raise InputError(f"--resume {resume} goes on with one run, but there are {scenarios} scenarios; give one")
        return cls(tuple(time_of("--checkpoint", text) for text in times or ()), resume)

    def arguments(self, folder: Path) -> Arguments:
        """Return what they are for ``simulate``, for results in a folder; raises `InputError` for another file."""
        found: Arguments = {}
        if self.at:
            found["checkpoint_at"] = self.at
            found["checkpoint_to"] = folder
        if self.resume is not None:
            found["resume"] = Checkpoint.load(self.resume)
        return found

    def files(self, result: Result) -> tuple[str, ...]:
        """Return the names of the files of checkpoints that a run has left."""
        return tuple(Checkpoint.file_name(at) for at in sorted(set(self.at))[: len(result.checkpoints)])

"""The errors a user can meet, and the exit code each leads to.

Every message says what is wrong, where, what was expected and what to do. An error that is not one of these is a
defect of the program.
"""

from __future__ import annotations

from pathlib import Path


class CosimError(Exception):
    """Anything that is reported to the user as a message and an exit code, never as a traceback."""

    exit_code = 1


class InputError(CosimError, ValueError):
    """Something the user wrote cannot be used: a scenario, an option, a model, an FMU.

    ``file``, ``line`` and ``column`` (both counted from 1) say where, as far as known; they are put in front of the
    message as ``file:line:column: ``.
    """

    exit_code = 2

    def __init__(
        self, message: str, *, file: Path | str | None = None, line: int | None = None, column: int | None = None
    ) -> None:
        """Put the place in front of the message."""
        self.file = file
        self.line = line
        self.column = column
        where = ":".join(str(part) for part in (file, line, column) if part is not None)
        super().__init__(f"{where}: {message}" if where else message)


class ModelError(InputError):
    """A Modelica model that cannot be compiled: what, file and line, and what would do."""


class ModelWarning(UserWarning):
    """Something in a Modelica model that is probably a mistake, although the model can be compiled."""


class FmuError(InputError):
    """An FMU that cannot be used: not an FMU, no binary for this platform, a variable it does not have."""


class FmuWarning(UserWarning):
    """Something in an FMU that the standard forbids, but that does no harm: it is read all the same."""


class MeasurementWarning(UserWarning):
    """Something in a measurement file that is wrong and has been mended; the message says how."""


class BuildError(CosimError, RuntimeError):
    """The C compiler is missing or failed."""

    exit_code = 3


class SimulationError(CosimError, RuntimeError):
    """A simulation that was started and could not be finished: time, component and what to try."""

    exit_code = 3

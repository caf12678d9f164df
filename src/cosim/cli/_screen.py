"""What a user sees: results on stdout, notes, errors and progress on stderr."""

from __future__ import annotations

import json
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import TYPE_CHECKING, NoReturn

import typer

from cosim.errors import CosimError, FmuWarning, InputError, MeasurementWarning, ModelWarning

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

INTERRUPTED = 130
"""Exit code after Ctrl-C, as shells have it."""

_TOLD = (FmuWarning, MeasurementWarning, ModelWarning)
_LONG_RUN = 0.7
"""A progress bar is shown for runs that take longer than this [s]."""


class Screen:
    """Prints what the options ask for: all, errors only (``quiet``), or one JSON document (``as_json``)."""

    def __init__(self, *, quiet: bool, as_json: bool) -> None:
        """Remember the options ``--quiet`` and ``--json``."""
        self.as_json = as_json
        self.talks = not (quiet or as_json)
        self.animates = self.talks and sys.stderr.isatty()

    def say(self, text: str) -> None:
        """Print a result, unless quiet or JSON is asked for."""
        if self.talks:
            typer.echo(text)

    def note(self, text: str) -> None:
        """Print something worth knowing that is no error."""
        if self.talks:
            typer.secho(f"note: {text}", err=True, fg="yellow")

    def warn(self, text: str) -> None:
        """Print something that is probably a mistake, but does not stop the command."""
        if self.talks:
            typer.secho(f"warning: {text}", err=True, fg="yellow")

    def error(self, text: str) -> None:
        """Print an error."""
        typer.secho(f"error: {text}", err=True, fg="red")

    def document(self, content: dict[str, object]) -> None:
        """Print the JSON document, if one is asked for."""
        if self.as_json:
            typer.echo(json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False))

    def fail(self, text: str, exit_code: int) -> NoReturn:
        """Print an error, in JSON too if that is asked for, and leave the command."""
        self.error(text)
        self.document({"error": text, "exit_code": exit_code})
        raise typer.Exit(exit_code)

    def working(self, text: str) -> AbstractContextManager[object]:
        """Show on a terminal that something takes its time."""
        if not self.animates:
            return nullcontext()
        from rich.console import Console

        return Console(stderr=True).status(text)

    @contextmanager
    def progress(self, text: str, stop: float) -> Iterator[Callable[[float], None] | None]:
        """Give a function that takes the simulated time [s] and moves a bar; None if there is nothing to show it on."""
        if not self.animates:
            yield None
            return
        bar = _Bar(text, stop)
        try:
            yield bar.move
        finally:
            bar.remove()


class _Bar:
    """A progress bar that appears only once a run turns out to be long."""

    def __init__(self, text: str, stop: float) -> None:
        self._text = text
        self._stop = stop
        self._started = time.perf_counter()
        self._shown: tuple[Progress, TaskID] | None = None

    def move(self, reached: float) -> None:
        if self._shown is None:
            if time.perf_counter() - self._started < _LONG_RUN:
                return
            self._shown = self._show()
        progress, task = self._shown
        progress.update(task, completed=reached)

    def remove(self) -> None:
        if self._shown is not None:
            self._shown[0].stop()

    def _show(self) -> tuple[Progress, TaskID]:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

        progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.completed:.1f} of {task.total:g} s"),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            transient=True,
        )
        task = progress.add_task(self._text, total=self._stop)
        progress.start()
        return progress, task


@contextmanager
def warned(screen: Screen) -> Iterator[list[str]]:
    """Print the warnings on models and FMUs of what runs inside, each once; the list holds them after it, for JSON."""
    texts: list[str] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            yield texts
        finally:
            texts += dict.fromkeys(str(w.message) for w in caught if issubclass(w.category, _TOLD))
            for text in texts:
                screen.warn(text)
    for other in caught:
        if not issubclass(other.category, _TOLD):
            warnings.warn_explicit(other.message, other.category, other.filename, other.lineno)


@contextmanager
def reporting(screen: Screen) -> Iterator[None]:
    """Turn the errors a user can meet, files that cannot be used, and Ctrl-C into a message and an exit code."""
    try:
        yield
    except CosimError as error:
        screen.fail(str(error), error.exit_code)
    except BrokenPipeError:  # who reads the output, such as head, has had enough; click ends the command
        raise
    except OSError as error:
        if error.filename is None:
            raise
        taken = isinstance(error, FileExistsError)
        reason = "there is a file of this name already" if taken else error.strerror or str(error)
        screen.fail(f"{error.filename}: cannot be read or written: {reason}; give another path", InputError.exit_code)
    except KeyboardInterrupt:
        screen.fail("interrupted", INTERRUPTED)

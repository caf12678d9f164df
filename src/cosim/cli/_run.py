"""``cosim run``: from scenario files to results, one after another."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path

from cosim.cli._builtin import locate
from cosim.cli._checkpoints import Arguments, Checkpoints
from cosim.cli._coupling import show_coupling, show_power
from cosim.cli._isolation import Isolation
from cosim.cli._screen import INTERRUPTED, Screen
from cosim.engine import Result, System, explain_timing, simulate
from cosim.errors import CosimError, FmuWarning, InputError, SimulationError
from cosim.report import Run, replacing, write
from cosim.scenario import Scenario, ScenarioWarning, Setting, assemble, read, read_parameters


@dataclass(frozen=True)
class Options:
    """What wins over the scenario files: what parameter files set, and over that texts ``name=value``; more faults."""

    settings: Sequence[str]
    parameters: Sequence[Setting]
    faults: Sequence[str] = ()

    @classmethod
    def of(
        cls, settings: Sequence[str] | None, files: Sequence[Path] | None, faults: Sequence[str] | None = None
    ) -> Options:
        """Read the parameter files; raises `InputError`."""
        parameters = [setting for file in files or [] for setting in read_parameters(file)]
        return cls(settings or [], parameters, faults or [])

    def read(self, file: Path) -> Scenario:
        """Read a scenario with them; raises `InputError`."""
        return read(file, self.settings, self.parameters, self.faults)


@dataclass
class Outcome:
    """How one scenario ended; ``summary`` is summary.json's content, if there is one in ``folder``."""

    scenario: str
    exit_code: int = 0
    message: str | None = None
    folder: str | None = None
    notes: list[str] = field(default_factory=list)
    summary: dict[str, object] | None = None
    timing: str | None = None


def explain_files(files: Sequence[Path], options: Options, screen: Screen, isolation: Isolation) -> int:
    """Tell when things happen in the runs of these scenarios, without running them; return the worst exit code."""
    outcomes: list[Outcome] = []
    for file in files:
        outcome = Outcome(str(file))
        outcomes.append(outcome)
        try:
            scenario = options.read(file)
            system = _assemble(scenario, outcome, screen)
            with _naming(file):
                outcome.timing = explain_timing(
                    system,
                    stop=scenario.stop,
                    output_interval=scenario.output_interval,
                    tolerance=scenario.tolerance,
                    algorithm=scenario.algorithm,
                    step=scenario.macro_step,
                    isolate=isolation.isolate,
                    call_timeout=isolation.call_timeout,
                    memory_limit=isolation.memory_limit,
                )
            screen.say(f"{file}\n\n{outcome.timing}\n")
        except CosimError as error:
            outcome.exit_code, outcome.message = error.exit_code, str(error)
            screen.error(outcome.message)
    return _report(outcomes, screen)


def run_files(
    files: Sequence[Path],
    out: Path,
    options: Options,
    screen: Screen,
    isolation: Isolation,
    *,
    plots: bool,
    coupling_error: bool = True,
    saving: Checkpoints = Checkpoints(),  # noqa: B008 - it cannot be changed
) -> int:
    """Run scenarios and write their results into ``out``; return the worst exit code.

    A scenario that is refused or fails does not keep the next ones from running; Ctrl-C does.
    """
    _check_folders(files)
    outcomes: list[Outcome] = []
    for file in files:
        outcome = Outcome(str(file))
        outcomes.append(outcome)
        folder = out / file.stem
        _run(outcome, file, folder, options, screen, isolation, saving, plots=plots, coupling_error=coupling_error)
        if outcome.message is not None:
            screen.error(outcome.message)
        if outcome.exit_code == INTERRUPTED:
            break
    return _report(outcomes, screen)


def _report(outcomes: Sequence[Outcome], screen: Screen) -> int:
    worst = max(outcome.exit_code for outcome in outcomes)
    screen.document({"exit_code": worst, "runs": [asdict(outcome) for outcome in outcomes]})
    return worst


def _check_folders(files: Sequence[Path]) -> None:
    """Refuse two files that would write into the same folder, where one would be lost."""
    by_stem: dict[str, Path] = {}
    for file in files:
        other = by_stem.setdefault(file.stem, file)
        if other is not file:
            raise InputError(
                f"{other} and {file} would both write into the folder '{file.stem}'; run them with different --out"
            )


def _run(
    outcome: Outcome,
    file: Path,
    folder: Path,
    options: Options,
    screen: Screen,
    isolation: Isolation,
    saving: Checkpoints,
    *,
    plots: bool,
    coupling_error: bool,
) -> None:
    try:
        scenario = options.read(file)
        system = _assemble(scenario, outcome, screen)
        checkpoints = saving.arguments(folder)
        with replacing(folder):
            result = _simulate(scenario, system, outcome, screen, isolation, coupling_error, checkpoints)
        if result is None:
            return
        outcome.folder = str(folder)
        asked = Run(
            scenario.stop,
            scenario.output_interval,
            scenario.tolerance,
            scenario.title,
            file.name,
            saving.resume.name if saving.resume else None,
            saving.files(result),
        )
        outcome.summary = write(result, system, asked, folder, plots=plots)
        if outcome.message is not None and result.complete:
            outcome.message += f"; its results are in {folder}"
        elif outcome.message is not None:
            outcome.message += f"; what was computed before is in {folder}, marked incomplete"
            if asked.checkpoints:
                outcome.message += f"; go on with --resume {folder / asked.checkpoints[-1]}"
        else:
            screen.say(_account(file, outcome.summary, folder))
            show_coupling(outcome.summary, screen)
            show_power(outcome.summary, screen)
    except CosimError as error:
        outcome.exit_code, outcome.message = error.exit_code, str(error)
    except OSError as error:
        outcome.exit_code = SimulationError.exit_code
        outcome.message = f"{folder}: the results cannot be written: {error.strerror}; choose another --out"
    except KeyboardInterrupt:
        outcome.exit_code, outcome.message = INTERRUPTED, f"{file}: interrupted"


def _assemble(scenario: Scenario, outcome: Outcome, screen: Screen) -> System:
    with warnings.catch_warnings(record=True) as caught, screen.working("getting the FMUs ready"):
        warnings.simplefilter("ignore")
        warnings.simplefilter("always", ScenarioWarning)
        warnings.simplefilter("always", FmuWarning)
        system = assemble(scenario, locate)
    outcome.notes = [str(warning.message) for warning in caught]
    for text in outcome.notes:
        screen.note(text)
    return system


def _simulate(
    scenario: Scenario,
    system: System,
    outcome: Outcome,
    screen: Screen,
    isolation: Isolation,
    coupling_error: bool,
    checkpoints: Arguments,
) -> Result | None:
    """Simulate; a run that ends early leaves its message in ``outcome`` and gives what it had, None if nothing."""
    try:
        with (
            _noting(outcome, screen),
            _naming(scenario.path),
            screen.progress(scenario.path.stem, scenario.stop) as progress,
        ):
            return simulate(
                system,
                stop=scenario.stop,
                output_interval=scenario.output_interval,
                tolerance=scenario.tolerance,
                algorithm=scenario.algorithm,
                step=scenario.macro_step,
                extrapolation=scenario.extrapolation,
                progress=progress,
                isolate=isolation.isolate,
                call_timeout=isolation.call_timeout,
                memory_limit=isolation.memory_limit,
                coupling_error=coupling_error,
                **checkpoints,
            )
    except (SimulationError, KeyboardInterrupt) as error:
        interrupted = isinstance(error, KeyboardInterrupt)
        outcome.exit_code = INTERRUPTED if interrupted else SimulationError.exit_code
        outcome.message = f"{scenario.path}: {str(error) or 'interrupted'}"
        partial: Result | None = getattr(error, "result", None)
        return partial


@contextmanager
def _noting(outcome: Outcome, screen: Screen) -> Iterator[None]:
    """Tell, after the run, of what was remarkable about the FMUs."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("ignore")
        warnings.simplefilter("always", FmuWarning)
        try:
            yield
        finally:
            texts = [str(warning.message) for warning in caught]
            outcome.notes = [*outcome.notes, *texts]
            for text in texts:
                screen.note(text)


@contextmanager
def _naming(file: Path) -> Iterator[None]:
    """Put the scenario's name in front of a refusal that names no file."""
    try:
        yield
    except InputError as error:
        if error.file is not None:
            raise
        raise InputError(str(error), file=file) from error


def _account(file: Path, summary: dict[str, object], folder: Path) -> str:
    """Tell a finished run in one line."""
    resumed = summary["resumed_from"]
    since = f", from {resumed['time_s']:.9g} s on," if isinstance(resumed, dict) else ""
    parts = [f"{file.stem}: {summary['reached']:g} s{since}"]
    if isinstance(wall := summary["wall_s"], float) and isinstance(factor := summary["real_time_factor"], float):
        parts[0] += f" in {wall:.3g} s, {factor:.3g} times real time"
    for key, unit in (("exchanges", "exchanges"), ("solver_steps", "solver steps"), ("events", "events")):
        if isinstance(count := summary[key], int):
            parts.append(f"{count} {unit}")
    return f"{'; '.join(parts)}; results in {folder}"

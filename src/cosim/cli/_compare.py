"""``cosim compare``: a result beside measurements, with a verdict."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path

from cosim.cli._choices import aliases, choices, measured, pictures, table
from cosim.cli._screen import Screen, warned
from cosim.comparison import SIGNALS, Comparison, Options, compare, draw, figure_names
from cosim.errors import InputError
from cosim.measurement import read

NOT_MET = 1
"""Exit code if a requirement is not met."""
_AT_LEAST = ("correlation", "coherence_mean")
"""Figures of which more is better; of all others the magnitude counts."""


def compare_files(
    result: Path,
    measurements: Sequence[Path],
    out: Path | None,
    settings: Sequence[str],
    columns: Sequence[str],
    measured_columns: Sequence[str],
    limits: Sequence[str],
    screen: Screen,
    *,
    require: bool,
    plots: bool,
) -> int:
    """Compare a result with each measurement, print and write the figures, draw pictures; return the exit code.

    Raises `InputError` for options and files that cannot be used.
    """
    options, names = (
        choices(Options, settings),
        aliases(columns, [signal for signal, _, _ in SIGNALS.values()] + ["phi_crank"]),
    )
    measured_names = measured(measured_columns)
    bounds = [_limit(text, figure_names(options.quantity)) for text in limits]
    folder = out if out is not None else result if result.is_dir() else result.parent
    found: list[Comparison] = []
    failures: list[str] = []
    for path in measurements:
        with warned(screen):
            comparison = compare(result, read(path, columns=measured_names), options, aliases=names)
        found.append(comparison)
        failures += [f"{comparison.measurement}: {text}" for text in _failures(comparison, bounds, require)]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        documents = [comparison.to_dict() for comparison in found]
        document = documents[0] if len(documents) == 1 else {"result": found[0].result, "comparisons": documents}
        (folder / "comparison.json").write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}", file=folder / "comparison.json") from error
    screen.say(describe(found))
    if plots:
        for comparison, picture in zip(found, pictures(folder, "comparison_", measurements), strict=True):
            draw(comparison, picture)
            screen.say(str(picture))
    screen.say(str(folder / "comparison.json"))
    for failure in failures:
        screen.error(f"required, but not so: {failure}")
    exit_code = NOT_MET if failures else 0
    screen.document(document | {"exit_code": exit_code, "failures": failures})
    return exit_code


def describe(found: Sequence[Comparison]) -> str:
    """Return the table that the command prints: a row for each figure, a column for each measurement."""
    head = ["", *(comparison.measurement for comparison in found)]
    figures = [comparison.figures() for comparison in found]
    rows = [[name, *(f"{each[name]:.5g}" for each in figures)] for name in figures[0]]
    rows.append(["tube", *("pass" if comparison.tube_pass else "FAIL" for comparison in found)])
    rows.append(["samples", *(str(len(comparison.pair.time)) for comparison in found)])
    notes = [f"note: {comparison.measurement}: {note}" for comparison in found for note in comparison.notes]
    return "\n".join(
        [f"{found[0].result}, {found[0].options.quantity}: simulated - measured", *table(head, rows), *notes]
    )


def _limit(text: str, known: Sequence[str]) -> tuple[str, float]:
    name, sign, value = (part.strip() for part in text.partition("="))
    try:
        bound = float(value)
    except ValueError:
        bound = math.nan
    if not sign or math.isnan(bound):
        raise InputError(f"--limit {text}: write NAME=NUMBER, such as --limit rmse_nm=1.5 or --limit correlation=0.9")
    if name not in known:
        raise InputError(f"--limit {name}: there is no such figure; there are {', '.join(known)}")
    return name, bound


def _failures(comparison: Comparison, bounds: Sequence[tuple[str, float]], require: bool) -> list[str]:
    figures = comparison.figures()
    failures = []
    if require and not comparison.tube_pass:
        outside = figures["tube_outside"]
        failures.append(f"the result leaves the tube for {outside:.2%} of the time")
    for name, bound in bounds:
        value = figures.get(name, math.nan)
        if name in _AT_LEAST and not value >= bound:
            failures.append(f"{name} is {value:.5g}, at least {bound:g} is required")
        elif name not in _AT_LEAST and not abs(value) <= bound:
            failures.append(f"{name} is {value:.5g}, at most {bound:g} is required")
    return failures

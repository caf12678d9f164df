"""``cosim score --vibration``: measures of results beside each other, and their ratios to a baseline."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from cosim.assessment import MEASURED, Comparison, Method, Vibration, compare, trace, vibration
from cosim.cli._choices import aliases, choices, table
from cosim.cli._screen import Screen
from cosim.errors import InputError


def measure_results(
    results: Sequence[Path], baseline: Path | None, settings: Sequence[str], columns: Sequence[str], screen: Screen
) -> int:
    """Measure results and print them as the columns of a table; return 0, or 2 if one cannot be measured.

    Raises `InputError` if the baseline cannot be.
    """
    method, names = choices(Method, settings), aliases(columns, MEASURED)
    reference = None if baseline is None else vibration(trace(baseline, aliases=names), method)
    documents: list[dict[str, object]] = []
    found: list[Vibration] = []
    exit_code = 0
    for place in results:
        try:
            measured = vibration(trace(place, aliases=names), method)
        except InputError as error:
            exit_code = error.exit_code
            screen.error(str(error))
            documents.append({"result": str(place), "error": str(error)})
            continue
        found.append(measured)
        comparison = {} if reference is None else {"comparison": compare(measured, reference).to_dict()}
        documents.append({"result": str(place)} | measured.to_dict() | comparison)
    if found:
        screen.say(describe(found, reference))
    against = {} if reference is None else {"baseline": {"result": str(baseline)} | reference.to_dict()}
    screen.document({"exit_code": exit_code} | against | {"results": documents})
    return exit_code


def describe(found: Sequence[Vibration], baseline: Vibration | None = None) -> str:
    """Return the text that the command prints: a row for each measure, a column for each result and each ratio."""
    shown = [*found, *([baseline] if baseline is not None else [])]
    ratios = [] if baseline is None else [compare(run, baseline) for run in found]
    labels = {key: f"{measure.label} [{measure.unit}]" for run in shown for key, measure in run.measures.items()}
    ratio_heads = ["ratio"] if len(ratios) == 1 else [f"{ratio.name} : baseline" for ratio in ratios]
    head = ["", *(run.name for run in shown), *ratio_heads]
    rows = [
        [
            label,
            *(f"{run[key]:.4g}" if key in run.measures else "-" for run in shown),
            *(f"{ratio.ratios[key]:.3g}" if key in ratio.ratios else "" for ratio in ratios),
        ]
        for key, label in labels.items()
    ]
    return "\n".join([*table(head, rows), "", *_lines(shown), *_notes(shown, ratios)])


def _lines(shown: Sequence[Vibration]) -> list[str]:
    units = {"torque": ("crank torque", "N.m"), "current": ("motor current", "A")}
    return [
        f"{run.name}, strongest lines of the {units[key][0]}: "
        + ", ".join(f"{amplitude:.3g} {units[key][1]} at {frequency:.3g} Hz" for frequency, amplitude in lines)
        for run in shown
        for key, lines in run.lines.items()
        if lines
    ]


def _notes(shown: Sequence[Vibration], ratios: Sequence[Comparison]) -> list[str]:
    own = [f"note: {run.name}: {note}" for run in shown for note in run.notes]
    return own + [f"note: {ratio.name} : {ratio.baseline}: {note}" for ratio in ratios for note in ratio.notes]

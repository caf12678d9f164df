"""``cosim score``: the thesis's criteria for the voltage profile, for results of ``cosim run``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from cosim.assessment import LOOKED_AT, Counts, Rules, Score, score, trace
from cosim.cli._choices import aliases, choices, table
from cosim.cli._screen import Screen
from cosim.errors import InputError


def score_results(results: Sequence[Path], settings: Sequence[str], columns: Sequence[str], screen: Screen) -> int:
    """Score results and print the verdicts; return 0, or 2 if one of the results cannot be scored."""
    rules = choices(Rules, settings)
    names = aliases(columns, LOOKED_AT)
    documents: list[dict[str, object]] = []
    exit_code = 0
    for place in results:
        try:
            found = score(trace(place, aliases=names), rules)
        except InputError as error:
            exit_code = error.exit_code
            screen.error(str(error))
            documents.append({"result": str(place), "error": str(error)})
            continue
        documents.append({"result": str(place)} | found.to_dict())
        screen.say(describe(found) + "\n")
    screen.document({"exit_code": exit_code, "results": documents})
    return exit_code


def describe(found: Score) -> str:
    """Return the text that the command prints: counts, revolutions, failures."""
    lines = [f"{found.name}: {len(found.revolutions)} revolutions in {found.rules.span:g} s", ""]
    lines += table(
        ["", "park (literal)", "park (deceleration)", "turn"],
        [_counts("all", found.counts), _counts("without the first", found.counts_without_first)],
    )
    if found.revolutions:
        lines += ["", *table(["revolution", "from [s]", "to [s]", "at park", "park", "turn", "turned at [s]"], [
            [
                str(r.number),
                f"{r.start:.3f}",
                f"{r.end:.3f}",
                r.state_at_park,
                "literal" if r.park_literal else "yes" if r.park_deceleration else "no",
                "yes" if r.turn else "no",
                "" if r.turn_time is None else f"{r.turn_time:.3f}",
            ]
            for r in found.revolutions
        ])]  # fmt: skip
    if found.failures:
        rows = [
            [f"{f.time:.3f} s", str(f.revolution), _criterion(f.criterion, f.reading), f.reason] for f in found.failures
        ]
        lines += ["", *table(["failure at", "revolution", "criterion", "because"], rows, left=(2, 3))]
    return "\n".join(lines + [f"note: {note}" for note in found.notes])


def _counts(name: str, counts: Counts) -> list[str]:
    parks = [f"{passed}/{counts.park_total}" for passed in (counts.park_literal, counts.park_deceleration)]
    return [name, *parks, f"{counts.turn}/{counts.turn_total}"]


def _criterion(number: int, reading: str) -> str:
    names: Mapping[int, str] = {1: "1 park", 2: "2 turn", 3: "3 once"}
    return f"{names[number]} (literal)" if reading == "literal" else names[number]

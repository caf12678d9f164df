"""``cosim thesis``: the source's figures and table 4.1 from simulations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path

from cosim.assessment import Rules
from cosim.cli._builtin import locate
from cosim.cli._choices import choices
from cosim.cli._screen import Screen, warned
from cosim.fmu.catalogue import data_folder
from cosim.thesis import reproduce


def reproduce_thesis(
    out: Path, settings: Sequence[str], measured: Path | None, screen: Screen, *, sensitive: bool
) -> None:
    """Make everything in ``out``, with the study of open choices if ``sensitive``, and say what was made."""
    rules = choices(Rules, settings) if settings else None
    with warned(screen), screen.working("simulating and drawing") as status:
        update: Callable[[str], None] = getattr(status, "update", lambda _: None)
        made = reproduce(
            out, data_folder() / "scenarios", locate, rules=rules, measured=measured, sensitive=sensitive, say=update
        )
    screen.document({
        "files": [str(path) for path in made.files],
        "table_4_1": [{"sample_time_s": run.sample_time, "load": run.load} | run.score.to_dict() for run in made.rig],
        "claims": [asdict(finding) | {"verdict": finding.verdict.value} for finding in made.findings],
        **({} if made.varied is None else {"open_choices": [made.varied.conclusion, made.varied.deciding]}),
    })  # fmt: skip
    for path in made.files:
        screen.say(str(path))
    if made.varied is not None:
        screen.say(f"\n{made.varied.conclusion}\n\n{made.varied.deciding}".replace("**", ""))

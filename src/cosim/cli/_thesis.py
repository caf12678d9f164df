"""``cosim thesis``: the source's figures and table 4.1 from simulations."""

from __future__ import annotations

from pathlib import Path

from cosim.cli._builtin import locate
from cosim.cli._screen import Screen
from cosim.fmu.catalogue import data_folder
from cosim.thesis import reproduce


def reproduce_thesis(out: Path, screen: Screen) -> None:
    """Make everything in ``out`` and say what was made."""
    with screen.working("simulating and drawing"):
        made = reproduce(out, data_folder() / "scenarios", locate)
    screen.document({
        "files": [str(path) for path in made.files],
        "table_4_1": [{"sample_time_s": run.sample_time, "load": run.load} | run.score.to_dict() for run in made.rig],
    })  # fmt: skip
    for path in made.files:
        screen.say(str(path))

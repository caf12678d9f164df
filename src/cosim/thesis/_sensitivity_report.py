"""The study of open choices as files: a table of all runs, a picture, a page."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from cosim.thesis._runs import Locate
from cosim.thesis._sensitivity import study, write_runs
from cosim.thesis._sensitivity_page import conclusion, deciding, page
from cosim.thesis._sensitivity_picture import draw


@dataclass(frozen=True)
class Sensitivity:
    """What was made: the files, whether the source's conclusion stands, and which open choice decides."""

    files: tuple[Path, ...]
    conclusion: str
    deciding: str


def sensitivity(
    out: Path,
    scenarios: Path,
    locate: Locate,
    *,
    picture: str = "sensitivity.png",
    say: Callable[[str], None] = lambda _: None,
) -> Sensitivity:
    """Vary what the source leaves open in the runs of table 4.1; write ``sensitivity.csv``, ``.png`` and ``.md``.

    Args:
        out: a folder, made if it is missing.
        scenarios: the folder of the shipped scenarios.
        locate: gives the FMU of a built-in plant or controller.
        picture: path of the picture from the page.
        say: is told what comes next.

    Raises:
        CosimError: an FMU cannot be built, or a simulation fails.
    """
    found = study(scenarios, locate, say)
    say("the picture of the open choices")
    table, drawing, text = (out / name for name in ("sensitivity.csv", picture, "sensitivity.md"))
    for file in (table, drawing, text):
        file.parent.mkdir(parents=True, exist_ok=True)
    write_runs(found.tables, table)
    draw(found, drawing)
    text.write_text(page(found, picture), encoding="utf-8")
    return Sensitivity((table, drawing, text), conclusion(found), deciding(found))

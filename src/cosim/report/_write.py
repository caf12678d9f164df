"""A run's folder: everything that is written about one run."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from cosim.engine import Result, System
from cosim.errors import InputError
from cosim.report._plots import FIGURES, plot
from cosim.report._summary import Run, summarize
from cosim.report._tables import write_csv, write_parquet

_FILES = ("results.csv", "results.parquet", "summary.json", *(f"{figure}.png" for figure in FIGURES))
_ASIDE = ".earlier"
"""Ending of the names of what an earlier run has left, until the new one has begun."""


@contextmanager
def replacing(folder: Path) -> Iterator[None]:
    """Make the folder, and put aside what an earlier run left in it, so that nothing there belongs to another run.

    In the end that is removed, or put back if the new run is refused before it begins (`InputError`). Raises
    `InputError` if the folder cannot be made or written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name in _FILES:
            (folder / f"{name}{_ASIDE}").unlink(missing_ok=True)
            if (folder / name).exists():
                (folder / name).rename(folder / f"{name}{_ASIDE}")
    except OSError as error:
        raise InputError(f"cannot write results there: {error.strerror}; choose another --out", file=folder) from error
    try:
        yield
    except InputError:
        for kept in folder.glob(f"*{_ASIDE}"):
            kept.rename(kept.with_name(kept.name.removesuffix(_ASIDE)))
        raise
    finally:
        for left in folder.glob(f"*{_ASIDE}"):
            left.unlink(missing_ok=True)


def write(result: Result, system: System, run: Run, folder: Path, *, plots: bool = True) -> dict[str, object]:
    """Write results.csv, results.parquet, summary.json and, if asked, PNG plots into ``folder``; return the summary.

    An incomplete result is written like a complete one; summary.json says ``complete: false`` and why.
    """
    summary = summarize(result, system, run)
    write_csv(result, folder / "results.csv")
    lasting = ("title", "scenario", "complete", "message", "parameters", "enumerations", "versions", "faults")
    write_parquet(result, folder / "results.parquet", {key: summary[key] for key in lasting})
    text = json.dumps(summary, indent=2, ensure_ascii=False, allow_nan=False)
    (folder / "summary.json").write_text(text + "\n", encoding="utf-8", newline="\n")
    if plots:
        plot(result, folder, run.title)
    return summary

"""``cosim export-ssp``: a scenario as a system structure package, and a scenario that runs it."""

from __future__ import annotations

import warnings
from pathlib import Path

from cosim.cli._builtin import locate
from cosim.cli._screen import Screen
from cosim.errors import InputError
from cosim.scenario import ScenarioWarning, assemble, read
from cosim.scenario.companion import companion
from cosim.ssp import VERSIONS, connector_names, write_ssp


def export_ssp(file: Path, out: Path | None, version: str, settings: list[str], screen: Screen) -> tuple[Path, Path]:
    """Write the SSP, by default ``SCENARIO.ssp`` here, and beside it ``SCENARIO_ssp.csv``; return both paths."""
    if version not in VERSIONS:
        raise InputError(f"--ssp {version}: accepted are {' and '.join(VERSIONS)}")
    out = Path(f"{file.stem}.ssp") if out is None else out
    if out.suffix.lower() != ".ssp":
        raise InputError(f"--out {out}: give the path of an .ssp file")
    beside = out.with_name(f"{out.stem}_ssp.csv")
    if beside.resolve() == file.resolve():
        raise InputError(
            f"--out {out}: {beside}, which is written beside it, is the scenario itself; give another name"
        )
    scenario = read(file, settings)
    with warnings.catch_warnings(record=True) as caught, screen.working("getting the FMUs ready"):
        warnings.simplefilter("ignore")
        warnings.simplefilter("always", ScenarioWarning)
        system = assemble(scenario, locate)
    for warning in caught:
        screen.note(str(warning.message))
    write_ssp(system, out, name=file.stem, title=scenario.title, stop=scenario.stop, version=version)
    text = companion(scenario, system, connector_names(system), out.name)
    try:
        beside.write_text(text, encoding="utf-8", newline="\n")
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", file=beside) from error
    return out, beside

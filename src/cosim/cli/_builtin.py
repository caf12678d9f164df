"""The way from the commands to what builds FMUs."""

from __future__ import annotations

from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING

from cosim.errors import InputError

if TYPE_CHECKING:
    from cosim.fmu.versions import FmiChoice


def check_target(platform: str, fmi: str) -> FmiChoice:
    """Return the choice of FMI versions; refuse others, and platforms that are not built, with `InputError`."""
    if platform != "host":
        raise InputError(f"--platform {platform}: this version builds for 'host' only, the machine it runs on")
    choices: dict[str, FmiChoice] = {"3.0": "3.0", "2.0": "2.0", "both": "both"}
    if fmi not in choices:
        raise InputError(f"--fmi {fmi}: FMUs are built for FMI 3.0 or 2.0; accepted are {', '.join(choices)}")
    return choices[fmi]


def locate(name: str) -> Path:
    """Return the FMU of a built-in plant or controller, built if it is out of date; `InputError` for other names."""
    from cosim.fmu import catalogue

    _check_names([name], _known())
    path: Path = catalogue.ensure(name)
    return path


def build_all(names: list[str] | None, out: Path | None, fmi: FmiChoice, *, strict_units: bool = False) -> list[Path]:
    """Build the named built-in FMUs, or all of them, into ``out`` or the default place.

    ``strict_units`` looks at the units of all of them first, also of those that are up to date.
    """
    from cosim.fmu import catalogue

    _check_names(names or [], _known())
    if strict_units:
        from cosim.modelica import Source, check_units, flatten, refuse_mismatches

        for name, entry in catalogue.names().items():
            if not names or name in names or entry.fmu_name in names:
                flat = flatten(Source.read(entry.source), entry.model)
                refuse_mismatches(flat, check_units(flat))
    paths: list[Path] = catalogue.build(names, out, fmi)
    return paths


def export_model(file: Path, model: str, out: Path, fmi: FmiChoice, *, strict_units: bool = False) -> list[Path]:
    """Compile a Modelica model into an FMU, or one of each FMI version, in the folder ``out``."""
    from cosim.fmu import export_all

    check_there(file)
    paths: list[Path] = export_all(file, model, out, fmi=fmi, strict_units=strict_units)
    return paths


def explanation(file: Path, model: str) -> str:
    """Return how the equations of a Modelica model were sorted and solved for."""
    from cosim.dae import explain
    from cosim.fmu import compile_model

    check_there(file)
    return explain(compile_model(file, model))


def check_there(path: Path) -> None:
    """Raise `InputError` if there is no such Modelica file or folder."""
    if not path.exists():
        raise InputError("there is no such Modelica file or folder", file=path)


def _known() -> dict[str, str]:
    """Return the built-in FMUs: their names in scenarios, and the names of their files without ending."""
    from cosim.fmu import catalogue

    return {name: entry.fmu_name for name, entry in catalogue.names().items()}


def _check_names(names: list[str], known: dict[str, str]) -> None:
    for name in names:
        if name not in known and name not in known.values():
            near = get_close_matches(name, [*known, *known.values()], n=1)
            hint = f", did you mean '{near[0]}'?" if near else ""
            raise InputError(
                f"no built-in plant or controller '{name}'{hint}; built in are {', '.join(known)}; "
                "an FMU of your own is given by its path, ending in .fmu"
            )

"""The way from the commands to what builds FMUs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from cosim.errors import BuildError, InputError

if TYPE_CHECKING:
    from cosim.fmu.versions import FmiChoice


def check_target(platforms: str, fmi: str) -> FmiChoice:
    """Return the choice of FMI versions; refuse others, and platforms there are no builds for, with `InputError`."""
    from cosim.fmu.toolchain import chosen
    from cosim.fmu.versions import versions_of

    choices: dict[str, FmiChoice] = {"3.0": "3.0", "2.0": "2.0", "both": "both"}
    if fmi not in choices:
        raise InputError(f"--fmi {fmi}: FMUs are built for FMI 3.0 or 2.0; accepted are {', '.join(choices)}")
    for version in versions_of(choices[fmi]):
        try:
            chosen(platforms, version)
        except BuildError as error:
            raise InputError(f"--platform {platforms}: {error}") from error
    return choices[fmi]


def locate(name: str) -> Path:
    """Return the FMU of a built-in plant or controller, built if it is out of date; `InputError` for other names."""
    from cosim.fmu import catalogue

    path: Path = catalogue.ensure(name)
    return path


def build_all(
    names: list[str] | None,
    out: Path | None,
    fmi: FmiChoice,
    platforms: str,
    *,
    strict_units: bool = False,
    with_sources: bool | None = None,
) -> list[Path]:
    """Build the named built-in FMUs, or all of them, into ``out`` or the default place.

    ``strict_units`` looks at the units of all of them first, also of those that are up to date.
    """
    from cosim.fmu import catalogue

    if strict_units:
        from cosim.modelica import Source, check_units, flatten, refuse_mismatches

        entries = [catalogue.entry_of(name) for name in names or catalogue.names()]
        for entry in [entry for entry in entries if not entry.by_hand]:
            flat = flatten(Source.read(entry.source), entry.model)
            refuse_mismatches(flat, check_units(flat))
    paths: list[Path] = catalogue.build(names, out, fmi, platforms, with_sources=with_sources)
    return paths


def export_model(
    file: Path,
    model: str,
    out: Path,
    fmi: FmiChoice,
    platforms: str,
    *,
    strict_units: bool = False,
    explain: bool = False,
    with_sources: bool | None = None,
    fixed_step: float | None = None,
) -> tuple[list[Path], str | None]:
    """Compile a Modelica model into an FMU, or one of each FMI version, in the folder ``out``; return the paths.

    With ``explain`` also how its equations were sorted and solved for.
    """
    from cosim.fmu import compile_model, pack_all

    check_there(file)
    dae = compile_model(file, model, strict_units=strict_units)
    paths: list[Path] = pack_all(
        dae, out, fmi=fmi, platforms=platforms, with_sources=with_sources, fixed_step=fixed_step
    )
    if not explain:
        return paths, None
    from cosim.dae import explain as explanation

    return paths, explanation(dae)


def step_of(text: str | None) -> float | None:
    """The length [s] that ``--fixed-step`` gives, such as "1 ms"; `InputError` for anything but a positive time."""
    if text is None:
        return None
    from cosim.units import compatible, convert, parse, quantity

    number, unit = quantity(text)
    if not compatible(unit, parse("s")):
        raise InputError(f"--fixed-step {text}: write a time, such as 1ms")
    seconds = convert(number, unit, parse("s"))
    if not 1e-6 <= seconds < float("inf"):
        raise InputError(f"--fixed-step {text}: a step is at least 1 us long")
    return seconds


def check_there(path: Path) -> None:
    """Raise `InputError` if there is no such Modelica file or folder."""
    if not path.exists():
        raise InputError("there is no such Modelica file or folder", file=path)

"""What an FMU says of itself, read without unpacking it: also one that cannot be run on this computer."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cosim.archive import Archive
from cosim.check._subject import Subject
from cosim.engine.fmu._variable import type_of
from cosim.foreign import read_description

Start = float | int | bool | str | list[float | int | bool | str]


@dataclass(frozen=True)
class About:
    """A variable, or an array of them: ``type`` is "Real", "Integer", ..., ``fmi_type`` what FMI calls it.

    ``start``, ``minimum`` and ``maximum`` are in ``unit``, None if the FMU gives none; ``shape`` is empty for a scalar;
    ``literals`` are names of an enumeration, by number.
    """

    name: str
    type: str
    fmi_type: str
    causality: str
    variability: str
    unit: str | None
    description: str | None
    start: Start | None
    value_reference: int
    shape: tuple[int, ...]
    minimum: float | None
    maximum: float | None
    literals: dict[int, str] | None


@dataclass(frozen=True)
class Description:
    """An FMU at a glance.

    ``facts`` has what is said of the model as a whole, ``interfaces`` what each interface claims, ``experiment`` start,
    stop, tolerance and step [s] as far as given, ``binaries`` the size of the libraries [bytes] by platform, ``amiss``
    what breaks the standard without harm.
    """

    path: Path
    facts: dict[str, str | None]
    size: int
    unpacked_size: int
    interfaces: dict[str, dict[str, bool | int | float | str]]
    experiment: dict[str, float]
    binaries: dict[str, int]
    has_sources: bool
    n_states: int
    n_indicators: int
    variables: tuple[About, ...]
    amiss: tuple[str, ...]


def describe(path: Path | str) -> Description:
    """Read what an FMU says of itself; raises FmuError if it is dangerous to unpack or cannot be read."""
    archive = Archive.open(path)
    subject = Subject(archive, read_description(archive))
    given = subject.description
    experiment = given.defaultExperiment
    times = {name: getattr(experiment, name, None) for name in ("startTime", "stopTime", "tolerance", "stepSize")}
    return Description(
        path=archive.path,
        facts={
            "model": given.modelName,
            "description": given.description,
            "fmi_version": f"{given.fmiMajorVersion}.0",
            "version": given.version,
            "author": given.author,
            "copyright": given.copyright,
            "license": given.license,
            "generation_tool": given.generationTool,
            "generation_date": given.generationDateAndTime,
            "sha256": archive.sha256,
        },
        size=archive.size,
        unpacked_size=sum(archive.sizes.values()),
        interfaces={name: _claims(interface) for name, interface in _elements(subject)},
        experiment={name: number for name, text in times.items() if (number := _number(text)) is not None},
        binaries={
            folder: sum(archive.sizes[f"binaries/{folder}/{file}"] for file in files)
            for folder, files in sorted(subject.folders.items())
        },
        has_sources=any(name.startswith("sources/") for name in archive.sizes),
        n_states=int(given.numberOfContinuousStates or 0),
        n_indicators=int(given.numberOfEventIndicators or 0),
        variables=tuple(_about(variable) for variable in subject.variables),
        amiss=tuple(str(one) for one in subject.read.amiss),
    )


def _elements(subject: Subject) -> list[tuple[str, Any]]:
    """Return the elements of the interfaces; fmpy leaves out some of their attributes."""
    if subject.fmi == 1:
        return [(name, {"modelIdentifier": one.modelIdentifier}) for name, one in subject.interfaces.items()]
    return [(name, dict(subject.element(name).attrib)) for name in subject.interfaces]


def _claims(attributes: dict[str, str]) -> dict[str, bool | int | float | str]:
    found: dict[str, bool | int | float | str] = {}
    for name, text in attributes.items():
        number = _number(text)
        if text.lower() in ("true", "false"):
            found[str(name)] = text.lower() == "true"
        elif name != "modelIdentifier" and number is not None:
            found[str(name)] = int(number) if number.is_integer() else number
        else:
            found[str(name)] = text
    return found


def _about(variable: Any) -> About:  # noqa: ANN401 - fmpy has no types
    declared = variable.declaredType
    kind = type_of(variable.type) or variable.type
    items = declared.items if declared is not None and kind == "Enumeration" else []
    return About(
        name=variable.name,
        type=kind,
        fmi_type=variable.type,
        causality=variable.causality,
        variability=variable.variability,
        unit=variable.unit or (declared.unit if declared is not None else None),
        description=variable.description,
        start=_start(kind, variable.start, bool(variable.shape)),
        value_reference=variable.valueReference,
        shape=tuple(variable.shape or ()),
        minimum=_number(variable.min or (declared.min if declared is not None else None)),
        maximum=_number(variable.max or (declared.max if declared is not None else None)),
        literals={int(item.value): str(item.name) for item in items if (item.value or "").isdigit()} or None,
    )


def _start(kind: str, text: str | None, is_array: bool) -> Start | None:
    if text is None or kind in ("String", "Binary", "Clock"):
        return text
    values = [_value(kind, token) for token in text.split()]
    return values if is_array or len(values) != 1 else values[0]


def _value(kind: str, token: str) -> float | int | bool | str:
    if kind == "Boolean":
        return token in ("true", "1")
    try:
        return float(token) if kind == "Real" else int(token)
    except ValueError:
        return token


def _number(text: str | None) -> float | None:
    """Return a finite number; None for what is none."""
    try:
        number = float(text or "")
    except ValueError:
        return None
    return number if math.isfinite(number) else None

"""The table of parameters: every value of both plants and the controller, with where it comes from."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from cosim.engine import Fmu, Variable
from cosim.scenario import assemble, read
from cosim.thesis._runs import Locate

MODELS = ("linkage", "rig", "rig_switched", "voltage_profile")
"""Both plants, the rig once more with the switched bridge of figure 4.8, and the controller."""
_PROVENANCE = re.compile(r"\[[SA]\]")
_INPUTS = {"v_supply": "[S] 4.2.1"}
"""Inputs that have a value before anything drives them, and its provenance."""
COLUMNS = ("name", "value", "unit", "models", "provenance", "description", "rig_runs")


@dataclass(frozen=True)
class Parameter:
    """A parameter that a user can set; ``models`` are those that have it with this value.

    ``provenance`` begins with [S] and the place in the source, or with [A] and the reason for what is assumed.
    ``rig_runs`` is what the runs of table 4.1 set instead, empty if they keep the value.
    """

    name: str
    value: str
    unit: str
    models: tuple[str, ...]
    provenance: str
    description: str
    rig_runs: str = ""

    @property
    def stated(self) -> bool:
        """Whether the source gives the value."""
        return self.provenance.startswith("[S]")


def parameters(scenarios: Path, locate: Locate) -> list[Parameter]:
    """Return the parameters of the models, those that several have alike once."""
    changed = _rig_settings(scenarios, locate)
    found: dict[tuple[str, ...], list[str]] = {}
    for model in MODELS:
        for variable in _settable(Fmu.read(locate(model))):
            described, provenance = _split(variable.description or "")
            provenance = _INPUTS.get(variable.name, provenance)
            rig_runs = changed.get(variable.name, "") if model == "voltage_profile" else ""
            key = (variable.name, _text(variable), _unit(variable), provenance, described, rig_runs)
            found.setdefault(key, []).append(model)
    return [
        Parameter(name, value, unit, tuple(models), provenance, described, rig_runs)
        for (name, value, unit, provenance, described, rig_runs), models in found.items()
    ]


def write_parameters(found: list[Parameter], path: Path) -> None:
    """Write the table as CSV."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(
            (p.name, p.value, p.unit, " ".join(p.models), p.provenance, p.description, p.rig_runs) for p in found
        )


def _settable(fmu: Fmu) -> Iterator[Variable]:
    return (v for v in fmu.variables.values() if v.causality == "parameter" or v.name in _INPUTS)


def _rig_settings(scenarios: Path, locate: Locate) -> dict[str, str]:
    """Return what the scenarios of table 4.1 set of the controller; T_sample differs from run to run."""
    system = assemble(read(scenarios / "rig_20ms.csv"), locate)
    (controller,) = (c for c in system.components if c.name == "controller")
    return {
        name: "1, 2, 10, 20, 50 ms" if name == "T_sample" else _number(value)
        for name, value in controller.parameters.items()
    }


def _split(description: str) -> tuple[str, str]:
    mark = _PROVENANCE.search(description)
    if mark is None:
        return description.strip(), ""
    return description[: mark.start()].strip(), description[mark.start() :].strip()


def _text(variable: Variable) -> str:
    if variable.type == "Boolean":
        return "true" if variable.start else "false"  # FMI's default where a file gives none
    return _number(variable.start)


def _number(value: object) -> str:
    return f"{value:.10g}" if isinstance(value, float) else str(value)


def _unit(variable: Variable) -> str:
    return "" if variable.unit in (None, "1") else str(variable.unit)

"""Blocks that feed through, wired to algebraic loops, and what their initialisation finds and costs.

The model is tests/models/Loops/Block.mo.
"""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from fmu_builder import edited

from cosim.engine import Component, Connection, Fmu, System
from cosim.engine._execution import Job, instantiated
from cosim.engine.fmu._calls import Site
from cosim.engine.loop._initialize import initialize
from cosim.engine.loop._plan import Plan
from cosim.engine.system._parameters import parameters_of
from cosim.fmu import export

MODELS = Path(__file__).parents[1] / "models" / "Loops"
TOLERANCE = 1e-6


class Blocks:
    """The block as FMUs of both versions, plain or with an edited description."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._paths: dict[int, Path] = {}
        self._opened: dict[tuple[int, str], Fmu] = {}

    def plain(self, version: int = 3) -> Fmu:
        """Return it as it is exported, with directional derivatives and dependencies."""
        return self._get(version, "plain")

    def bare(self, version: int = 3) -> Fmu:
        """Return it without directional derivatives, and without a statement on what depends on what."""
        return self._get(version, "bare")

    def liar(self, version: int = 3) -> Fmu:
        """Return it with the statement that no output depends on any input."""
        return self._get(version, "liar")

    def forward(self, version: int = 3) -> Fmu:
        """Return it without states to go back to."""
        return self._get(version, "forward")

    def start(self, u: float, version: int = 3) -> Fmu:
        """Return it with another start value of u."""
        return self._get(version, f"{u}")

    def exchange(self) -> Fmu:
        """Return it for Model Exchange."""
        return self._get(3, "exchange")

    def close(self) -> None:
        for fmu in self._opened.values():
            fmu.close()

    def _get(self, version: int, kind: str) -> Fmu:
        if (version, kind) not in self._opened:
            self._opened[version, kind] = self._open(version, kind)
        return self._opened[version, kind]

    def _open(self, version: int, kind: str) -> Fmu:
        if not self._paths:
            self._paths = {3: export(MODELS, "Loops.Block", self._folder, fmi="both")}
            self._paths[2] = self._folder / "Block.fmi2.fmu"
        path = self._paths[version]
        if kind == "plain":
            return Fmu.read(path)
        if kind == "exchange":
            return Fmu.read(path, "ModelExchange")

        def edit(text: str) -> str:
            if kind == "liar":
                return re.sub(r' dependencies="[^"]*" dependenciesKind="[^"]*"', ' dependencies=""', text)
            if kind == "bare":
                text = re.sub(r' dependencies="[^"]*" dependenciesKind="[^"]*"', "", text)
                return re.sub(r' providesDirectionalDerivatives?="true"', "", text)
            if kind == "forward":
                return re.sub(r' canGetAndSetFMU[sS]tate="true" canSerializeFMU[sS]tate="true"', "", text)
            assert text.count('start="0.5"') == 1
            return text.replace('start="0.5"', f'start="{kind}"')

        return Fmu.read(edited(path, self._folder / f"{kind}{version}.fmu", edit))


def wired(components: dict[str, tuple[Fmu, dict[str, float]]], *connections: str) -> System:
    """Return a system; "a.y b.u 2 1" connects with the factor 2 and the offset 1."""

    def connection(text: str) -> Connection:
        source, target, *numbers = text.split()
        ends = (tuple(end.split(".")) for end in (source, target))
        return Connection(*ends, *map(float, numbers))  # type: ignore[arg-type]

    parts = [Component(name, fmu, dict(parameters)) for name, (fmu, parameters) in components.items()]
    return System(parts, [connection(text) for text in connections])


@dataclass
class Counting(Site):
    """Counts the calls of one component."""

    tally: Counter[str] = field(default_factory=Counter)

    def enter(self, function: str) -> None:
        super().enter(function)
        self.tally[re.sub("Real|Float64|Boolean", "", function)] += 1


@dataclass
class Found:
    """What initialisation has found: values by "component.variable", remarks, and calls by component."""

    values: dict[str, float]
    remarks: list[str]
    calls: dict[str, Counter[str]]


def initialized(system: System) -> Found:
    """Initialise a system; raises CallError."""
    system.check()
    sites = [Counting(number=number, watched=True) for number in range(len(system.components))]
    with instantiated(Job(system, 1.0, 0.1, TOLERANCE), sites) as plan:
        for component in system.components:
            _instance(plan, component.name).set_values(parameters_of(component))
        for site in sites:
            site.tally.clear()
        remarks = initialize(plan, system, TOLERANCE, 1.0)
        calls = {component.name: site.tally.copy() for component, site in zip(system.components, sites, strict=True)}
        return Found({name: plan.values[slot] for name, slot in plan.columns.items()}, remarks, calls)


def _instance(plan: Plan, name: str):  # noqa: ANN202
    return next(p.instance for p in (*plan.continuous, *plan.discrete) if p.instance.name == name)

"""What a run was and what it cost: the content of summary.json."""

from __future__ import annotations

import math
import platform
import re
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from itertools import pairwise

from cosim import __version__
from cosim.engine import RANDOM_FAULTS, Component, Fault, Result, System, Variable

_PROVENANCE = re.compile(r"\[[SA]\].*", re.DOTALL)
# What the engine counts for each component, as it is called for one of them; its steps are calls of doStep.
_SINGULAR = {"roles": "role", "steps": "do_steps"}
_PACKAGES = ("fmpy", "numpy", "pyarrow", "casadi", "rumoca", "ziglang")


@dataclass(frozen=True)
class Run:
    """What was asked for: times in s, ``scenario`` the file's name.

    ``resumed_from`` is the name of the checkpoint's file from which the run has gone on, ``checkpoints`` are the names
    of those that it has written.
    """

    stop: float
    output_interval: float
    tolerance: float
    title: str = ""
    scenario: str = ""
    resumed_from: str | None = None
    checkpoints: tuple[str, ...] = ()


def summarize(result: Result, system: System, run: Run) -> dict[str, object]:
    """Return the summary of a run, ready for JSON: numbers that JSON does not know are texts such as ``inf``.

    ``wall_s`` [s], ``second_wall_s`` [s] of the run for the coupling error, and ``real_time_factor`` (simulated per
    elapsed time) are the only entries that differ between two runs of one scenario. ``resumed_from`` is None unless the
    run has gone on from a checkpoint: these three are then of the rest, and all counts from 0 on. ``coupling`` and
    ``power`` are as in ``Result``. ``solver_steps`` and ``rejected_steps`` are sums over the FMUs that publish them,
    else None.
    """
    statistics = result.statistics
    wall = statistics.get("wall_s")
    reached = float(result.time[-1]) if len(result.time) else 0.0
    begun = _number(statistics.get("resumed_at_s"))
    return {
        "title": run.title,
        "scenario": run.scenario,
        "complete": result.complete,
        "message": result.message,
        "stop": run.stop,
        "reached": reached,
        "output_interval": run.output_interval,
        "tolerance": run.tolerance,
        "rows": len(result.time),
        "resumed_from": None if begun is None else {"checkpoint": run.resumed_from, "time_s": begun},
        "checkpoints": list(run.checkpoints),
        "wall_s": wall,
        "real_time_factor": (reached - (begun or 0.0)) / wall if isinstance(wall, float) and wall > 0 else None,
        "second_wall_s": statistics.get("second_wall_s"),
        "exchanges": statistics.get("exchanges"),
        "solver_steps": _total(statistics, "steps"),
        "rejected_steps": _total(statistics, "rejected_steps"),
        "events": _events(statistics),
        "algorithm": statistics.get("algorithm"),
        "coupling": statistics.get("coupling", []),
        "power": statistics.get("power", []),
        "components": {component.name: _component(component, statistics) for component in system.components},
        "faults": faults(result, system),
        "linear_channels": linear_channels(system, run.output_interval),
        "parameters": parameters(system),
        "enumerations": {name: list(names) for name, names in result.literals.items()},
        "versions": _versions(),
    }


def _number(value: object) -> float | None:
    return value if isinstance(value, float) else None


def faults(result: Result, system: System) -> list[dict[str, object]]:
    """Return what was done on purpose, in the order in which it acted: amounts in ``unit``, None for an open end."""
    units = {f"{c.name}.{v.name}": v.unit for c in system.components for v in c.fmu.variables.values()}
    return [_fault(fault, units[".".join(fault.target)]) for fault in result.faults]


def _fault(fault: Fault, unit: str | None) -> dict[str, object]:
    drawn = fault.kind in RANDOM_FAULTS
    return {
        "target": ".".join(fault.target),
        "kind": fault.kind,
        "amount": None if fault.kind == "freeze" else fault.amount,
        "unit": {"freeze": None, "delay": "s", "scale": "1", "drop": "1"}.get(fault.kind, unit),
        "from_s": fault.start,
        "to_s": fault.stop if math.isfinite(fault.stop) else None,
        "every_s": fault.every,
        "seed": fault.seed if drawn else None,
    }


def linear_channels(system: System, output_interval: float) -> dict[str, dict[str, float]]:
    """Return, for each linear channel, how long a continuous component sees one value of it, and what that errs.

    No slope is handed on: over a step of ``output_interval`` [s] such an input holds its value in the step's middle.
    The largest error, in the input's unit, is half its largest change within a step; a step of the channel is exact.
    """
    found: dict[str, dict[str, float]] = {}
    for channel in system.channels:
        if not channel.linear:
            continue
        rows = list(zip(channel.times, channel.values, strict=True))
        changes = [
            abs(y1 - y0) * min(1.0, output_interval / (t1 - t0)) for (t0, y0), (t1, y1) in pairwise(rows) if t1 > t0
        ]
        largest = max(changes, default=0.0) / 2.0
        found[".".join(channel.target)] = {"held_for_s": output_interval, "largest_input_error": largest}
    return found


def parameters(system: System) -> dict[str, dict[str, object]]:
    """Return every parameter as ``component.name`` with value, unit and provenance.

    The provenance is the part of the FMU's description from ``[S]`` (the source says so, with place) or ``[A]``
    (assumed, with reason) on; None if it has no such part. It is that of the FMU's own value: where the run has set
    another, which ``set`` tells, it is what has set it.
    """
    return {
        f"{component.name}.{variable.name}": _parameter(component, variable)
        for component in system.components
        for variable in component.fmu.variables.values()
        if variable.causality in ("parameter", "structuralParameter")
    }


def _parameter(component: Component, variable: Variable) -> dict[str, object]:
    value = component.parameters.get(variable.name, variable.start)
    described = _PROVENANCE.search(variable.description or "")
    provenance = described[0].strip() if described else None
    if variable.name in component.parameters:
        provenance = component.origins.get(variable.name, "set by the user")
    return {
        "value": str(value) if isinstance(value, float) and not math.isfinite(value) else value,
        "unit": variable.unit,
        "provenance": provenance,
        "set": variable.name in component.parameters,
    }


def _component(component: Component, statistics: Mapping[str, object]) -> dict[str, object]:
    fmu = component.fmu
    counted = {
        _SINGULAR.get(key, key): by_name[component.name]
        for key, by_name in statistics.items()
        if isinstance(by_name, dict) and component.name in by_name
    }
    return {
        "fmu": fmu.path.name,
        "model": fmu.name,
        "fmi_version": fmu.fmi_version,
        "sha256": fmu.sha256,
        "generation_tool": fmu.generation_tool,
        **counted,
    }


def _solver(statistics: Mapping[str, object]) -> dict[str, dict[str, int]]:
    solver = statistics.get("solver")
    return solver if isinstance(solver, dict) else {}


def _total(statistics: Mapping[str, object], counter: str) -> int | None:
    counts = [counters[counter] for counters in _solver(statistics).values() if counter in counters]
    return sum(counts) if counts else None


def _events(statistics: Mapping[str, object]) -> int:
    """Sum up the events that components had in Event Mode and those that FMUs handled inside their own solvers."""
    handled = statistics.get("events")
    handed = handled if isinstance(handled, dict) else {}
    inside = [
        counters.get("state_events", 0) + counters.get("time_events", 0)
        for name, counters in _solver(statistics).items()
        if name not in handed
    ]
    return sum(handed.values()) + sum(inside)


def _versions() -> dict[str, str]:
    versions = {"cosim": __version__, "python": platform.python_version()}
    for package in _PACKAGES:
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            continue
    return versions | {"platform": f"{platform.system()} {platform.machine()}"}

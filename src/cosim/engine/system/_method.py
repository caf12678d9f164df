"""How continuous components are stepped together: what the user asks for, checked against what the FMUs can do."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import ceil
from typing import Literal, get_args

from cosim.engine.fmu._fmu import Fmu
from cosim.engine.fmu._fmu_state import why_not_saved
from cosim.engine.system._connection import Connection
from cosim.engine.system._graph import Loop, Phase, declared, loops_among
from cosim.engine.system._role import Role, fixed_step_of
from cosim.engine.system._system import SAME_INSTANT, Component, System
from cosim.errors import FmuError, FmuWarning, InputError

Algorithm = Literal["auto", "gauss-seidel", "jacobi", "extrapolated", "iterated", "adaptive"]
"""How the components of a system are stepped; see ``simulate``."""

_ORDERS = {"extrapolated": 1, "iterated": 2, "adaptive": 2}
"""Of the polynomials that continue the connected signals, unless the user chooses another."""


_GO_BACK = ("iterated", "adaptive")
"""Algorithms that repeat steps, from states that the FMUs give and take back."""


@dataclass(frozen=True)
class Method:
    """An algorithm for one system.

    ``step`` [s] is the longest macro step, None for as long as possible; ``order`` is that of the polynomials by which
    connected signals are continued into a step. Every interval between two instants is divided into ``parts`` at
    least. ``loops`` are the algebraic loops that links form, as the user reads them; ``accuracy`` is the power of the
    macro step with which the error of coupling falls.
    """

    algorithm: Algorithm
    step: float | None = None
    order: int = 0
    parts: int = 1
    loops: tuple[str, ...] = ()
    accuracy: int = 1

    def divisions(self, h: float) -> int:
        """Return into how many macro steps an interval of length h [s] between two instants is divided."""
        return self.parts * (1 if self.step is None else max(1, ceil(h / self.step - 1e-6)))

    @property
    def is_fixed(self) -> bool:
        """Tell whether all components, whatever their role, exchange every ``step`` and then only."""
        return self.algorithm == "jacobi"

    @property
    def is_coupled(self) -> bool:
        """Tell whether connected signals are more than held over a step."""
        return self.algorithm in _ORDERS

    @property
    def goes_back(self) -> bool:
        """Tell whether steps are repeated."""
        return self.algorithm in _GO_BACK


def links_of(system: System, roles: Mapping[str, Role], output_interval: float) -> list[Connection]:
    """Return the connections over which continuous components that take steps of any length act on each other."""
    free = {
        component.name: component.fmu
        for component in system.components
        if roles[component.name] is Role.CONTINUOUS and fixed_step_of(component, output_interval) == math.inf
    }
    links: list[Connection] = []
    for connection in system.connections:
        (source, output), (target, name) = connection.source, connection.target
        if source not in free or target not in free or source == target:
            continue
        variable = free[source].variables[output]
        if (variable.type, free[target].variables[name].type) == ("Real", "Real") and variable.variability not in (
            "discrete",
            "fixed",
            "constant",
        ):
            links.append(connection)
    return links


def fed_through(fmu: Fmu, name: str) -> list[str]:
    """Return the outputs that depend directly on an input, as far as the model description does not exclude it."""
    outputs = [v.name for v in fmu.variables.values() if v.causality == "output" and v.type == "Real"]
    return [o for o in outputs if (known := fmu.dependencies.get(o)) is None or name in known]


def holds_end(fmu: Fmu, name: str) -> bool:
    """Tell whether an input is better off with the value at the end of a step: one that is not corrected."""
    through = fed_through(fmu, name)
    if not through:
        return False
    arrays = any(fmu.variables[v].array is not None for v in (name, *through))
    return arrays or not fmu.has_continuous_states or not fmu.capabilities["providesDirectionalDerivative"]


def choose(
    system: System,
    roles: Mapping[str, Role],
    algorithm: str,
    *,
    step: float | None,
    extrapolation: int | None,
    stop: float,
    output_interval: float,
) -> Method:
    """Return the method for a checked system; raises InputError (FmuError) for what cannot be, warns (FmuWarning).

    "auto" takes the adaptive algorithm if continuous components act on each other, the extrapolating one if an FMU
    cannot take a step back, and else the plain one, which is exact then.
    """
    _check(algorithm, step, extrapolation, stop, output_interval)
    links = links_of(system, roles, output_interval)
    components = {component.name: component for component in system.components}
    ends = {name for link in links for name in (link.source[0], link.target[0])}
    members = [component for component in system.components if component.name in ends]
    lacking = [component for component in members if why_not_saved(component.fmu)]
    if algorithm == "auto":
        algorithm = _automatic(links, lacking)
    elif algorithm in _GO_BACK and lacking:
        raise FmuError(
            f"the algorithm {algorithm} repeats steps, but {_told(lacking)}; choose extrapolated",
            file=lacking[0].fmu.path,
        )
    if algorithm in _ORDERS and not links:
        algorithm = "gauss-seidel"  # nothing is coupled continuously, and there is nothing to gain
    order = _ORDERS.get(algorithm, 0) if extrapolation is None else extrapolation
    assert algorithm in get_args(Algorithm)
    loops = loops_among(links, declared(system.components, Phase.TIME))
    if algorithm not in _GO_BACK:
        _warn_of_loops(system, loops, algorithm, lacking)
    held = any(holds_end(components[c.target[0]].fmu, c.target[1]) for c in links)
    accuracy = 2 if order > 0 and not held else 1
    return Method(algorithm, step, order, loops=tuple(map(str, loops)), accuracy=accuracy)  # type: ignore[arg-type]


def _automatic(links: list[Connection], lacking: list[Component]) -> str:
    if not links:
        return "gauss-seidel"
    if not lacking:
        return "adaptive"
    warnings.warn(
        f"the steps in which components exchange are not adapted to the tolerance: {_told(lacking)}; see the coupling "
        "error, and choose a shorter step if it is too large",
        FmuWarning,
        stacklevel=5,
    )
    return "extrapolated"


def _warn_of_loops(system: System, loops: Iterable[Loop], algorithm: str, lacking: list[Component]) -> None:
    """Warn (FmuWarning) of loops that are not solved, if the model descriptions say that these are loops."""
    fmus = {component.name: component.fmu for component in system.components}
    remedy = "choose the algorithm adaptive or iterated"
    if lacking:
        remedy = f"to solve it would take going back to a state, but {_told(lacking)}"
    for loop in loops:
        if all(fmus[name].dependencies.get(output) is not None for name, output in (*loop.torn, *loop.others)):
            warnings.warn(
                f"the algebraic loop {loop} is not solved while the components are stepped: with the algorithm "
                f"{algorithm} what goes round it arrives a macro step late, and if its gain is above 1 it grows beyond "
                f"bounds; {remedy}",
                FmuWarning,
                stacklevel=4,
            )


def _told(lacking: Iterable[Component]) -> str:
    """Return why components cannot go back to a state."""
    return ", ".join(f"{component.name} ({component.fmu.name}) {why_not_saved(component.fmu)}" for component in lacking)


def _check(algorithm: str, step: float | None, extrapolation: int | None, stop: float, output_interval: float) -> None:
    if algorithm not in get_args(Algorithm):
        raise InputError(f"algorithm is {algorithm!r}; it can be {', '.join(get_args(Algorithm))}")
    if step is not None and not (math.isfinite(step) and step > 2.0 * SAME_INSTANT):
        raise InputError(f"step is {step}; a macro step is above {2.0 * SAME_INSTANT} s")
    if extrapolation is not None and (algorithm not in _ORDERS or extrapolation not in (0, 1, 2)):
        raise InputError(
            f"extrapolation is {extrapolation}, with the algorithm {algorithm}; it can be 0, 1 or 2, with "
            f"{', '.join(_ORDERS)}"
        )
    if algorithm != "jacobi":
        return
    if step is None:
        raise InputError("there is no step; the algorithm jacobi needs the length of its macro steps")
    for name, value in (("output_interval", output_interval), ("stop", stop)):
        if abs(value - round(value / step) * step) > 0.5 * SAME_INSTANT or value < step:
            raise InputError(f"{name} is {value:g} s; it must be a multiple of the macro step, {step:g} s")

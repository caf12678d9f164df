"""Plants cut into two FMUs that drive each other all the time, and what they do exactly.

The models are in tests/models/Split. Each system has a twin, the uncut plant as one FMU, and a reference that shares
nothing with either: a matrix exponential, or the equations written again and integrated to rounding errors. What
happens in them takes about a second.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from cosim.engine import Component, Connection, Fmu, System
from cosim.fmu import export

MODELS = Path(__file__).parents[1] / "models" / "Split"

Array = NDArray[np.float64]
Version = Literal[2, 3]


@dataclass(frozen=True)
class Coupled:
    """A plant in two parts.

    ``parts`` are the models by the names of the components, the parameters of these as in a ``Component``, ``twin`` is
    the model of the whole; ``columns`` maps each output of the parts to that of the twin. ``reference`` gives the
    values of the twin's outputs at times [s].
    """

    parts: dict[str, str]
    parameters: dict[str, dict[str, float]]
    connections: tuple[tuple[str, str], ...]
    twin: str
    columns: dict[str, str]
    reference: Callable[[Array], dict[str, Array]]


def linear(A: Array, b: Array, start: Array, times: Array) -> Array:
    """Return the solution of x' = A x + b at times [s], shape (len(times), len(start)), by the matrix exponential."""
    n = len(start)
    whole = np.zeros((n + 1, n + 1))
    whole[:n, :n], whole[:n, n] = A, b
    return np.array([(expm(whole * t) @ np.append(start, 1.0))[:n] for t in times])


def oscillator(times: Array) -> dict[str, Array]:
    """Two masses of 1 kg and 2 kg, each on a spring and a damper, coupled by another of both; the first deflected."""
    c, d, cc, dc = 10.0, 0.2, 5.0, 0.3
    m1, m2 = 1.0, 2.0
    A = np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [-(c + cc) / m1, -(d + dc) / m1, cc / m1, dc / m1],
            [0.0, 0.0, 0.0, 1.0],
            [cc / m2, dc / m2, -(c + cc) / m2, -(d + dc) / m2],
        ]
    )
    x1, v1, x2, v2 = linear(A, np.zeros(4), np.array([1.0, 0.0, 0.0, 0.0]), times).T
    return {"x1": x1, "v1": v1, "x2": x2, "v2": v2, "F": cc * (x2 - x1) + dc * (v2 - v1)}


def motor(times: Array) -> dict[str, Array]:
    """A motor at rest to which 1 V is applied."""
    R, L, k, J, d = 1.0, 0.5, 1.0, 0.25, 0.1
    A = np.array([[-R / L, -k / L], [k / J, -d / J]])
    i, w = linear(A, np.array([1.0 / L, 0.0]), np.zeros(2), times).T
    return {"i": i, "tau": k * i, "w": w}


def radiation(times: Array) -> dict[str, Array]:
    """A body that is heated by a swinging power and radiates to another, which cools in air."""
    s = 5.67e-8

    def rates(t: float, T: Array) -> list[float]:
        q = s * (T[0] ** 4 - T[1] ** 4)
        return [(400.0 * (1.0 + np.sin(4.0 * t)) - q) / 10.0, (q - 8.0 * (T[1] - 290.0)) / 15.0]

    found = solve_ivp(rates, (0.0, times[-1]), [350.0, 300.0], "DOP853", times, rtol=1e-13, atol=1e-11)
    T1, T2 = found.y
    return {"T1": T1, "T2": T2, "q": s * (T1**4 - T2**4)}


COUPLED = {
    # force in, motion out; motion in, force out at once
    "oscillator": Coupled(
        {"first": "MassOnSpring", "second": "MassWithCoupling"},
        {},
        (("first.x", "second.x1"), ("first.v", "second.v1"), ("second.F", "first.F")),
        "TwoMasses",
        {"first.x": "x1", "first.v": "v1", "second.x": "x2", "second.v": "v2", "second.F": "F"},
        oscillator,
    ),
    # the same plant, each mass with the coupling in it: motion in, motion out
    "displacement": Coupled(
        {"first": "MassBesideOther", "second": "MassBesideOther"},
        {"first": {"x0": 1.0}, "second": {"m": 2.0}},
        (
            ("first.x", "second.x_other"),
            ("first.v", "second.v_other"),
            ("second.x", "first.x_other"),
            ("second.v", "first.v_other"),
        ),
        "TwoMasses",
        {"first.x": "x1", "first.v": "v1", "second.x": "x2", "second.v": "v2"},
        oscillator,
    ),
    "motor": Coupled(
        {"winding": "Winding", "rotor": "Rotor"},
        {},
        (("winding.tau", "rotor.tau"), ("rotor.w", "winding.w")),
        "Motor",
        {"winding.i": "i", "winding.tau": "tau", "rotor.w": "w"},
        motor,
    ),
    # not linear
    "radiation": Coupled(
        {"heated": "HeatedBody", "radiating": "RadiatingBody"},
        {},
        (("heated.T", "radiating.T1"), ("radiating.q", "heated.q")),
        "TwoBodies",
        {"heated.T": "T1", "radiating.T": "T2", "radiating.q": "q"},
        radiation,
    ),
}
"""The systems by name."""


class CoupledSystems:
    """Makes the systems; each FMU is built in a folder when it is first needed, if it is not there, and read once."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._opened: dict[tuple[str, Version], Fmu] = {}

    def fmu(self, model: str, fmi: Version = 3) -> Fmu:
        """Return the FMU of a model of tests/models/Split."""
        if (model, fmi) not in self._opened:
            path = self._folder / (f"{model}.fmi2.fmu" if fmi == 2 else f"{model}.fmu")
            if not path.exists():
                export(MODELS, f"Split.{model}", self._folder, fmi="2.0" if fmi == 2 else "3.0")
            self._opened[model, fmi] = Fmu.read(path)
        return self._opened[model, fmi]

    def system(self, name: str, fmi: Version = 3) -> System:
        """Return a system in parts."""
        coupled = COUPLED[name]
        components = [
            Component(part, self.fmu(model, fmi), dict(coupled.parameters.get(part, {})))
            for part, model in coupled.parts.items()
        ]
        return System(components, [Connection(_end(source), _end(target)) for source, target in coupled.connections])

    def twin(self, name: str, fmi: Version = 3) -> System:
        """Return the same as one component, "whole"."""
        return System([Component("whole", self.fmu(COUPLED[name].twin, fmi))])

    def close(self) -> None:
        """Close the FMUs."""
        for fmu in self._opened.values():
            fmu.close()


def exact(name: str, times: Array) -> dict[str, Array]:
    """Return what the outputs of a system in parts are at times [s], as columns of a result."""
    values = COUPLED[name].reference(times)
    return {column: values[output] for column, output in COUPLED[name].columns.items()}


def _end(dotted: str) -> tuple[str, str]:
    component, _, variable = dotted.partition(".")
    return component, variable

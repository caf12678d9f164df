"""What a fit has to know of a plant beside its equations; all of it stays valid until the plant's sources change."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

import casadi as ca
import numpy as np

from cosim.calibration._equations import SUPPLY, SUPPLY_DROP, outputs_of
from cosim.dae import Dae
from cosim.engine import Channel, Component, System, simulate
from cosim.errors import InputError
from cosim.linear import observed, symbols_behind

_SETTLED, _STOP = 3.0, 12.0
"""The run is looked at from the former time [s] on, for a whole revolution at least, and ends at the latter."""
_ROWS = 200
"""So many angles of a revolution are kept."""


@dataclass(frozen=True)
class Parameter:
    """An independent parameter: its own value, in its unit, and its Modelica type."""

    name: str
    unit: str
    value: float
    type: str


@dataclass(frozen=True)
class Watched:
    """A relation that is held: the name of its symbol, its text, how it is true, and whether it is."""

    symbol: str
    text: str
    strict: bool
    value: bool


@dataclass(frozen=True)
class Plant:
    """Names and sizes of the variables, and a run with the plant's own parameters at full duty.

    ``held`` are the discrete variables and relations in steady forward running, by the names of their symbols.
    ``at_rest`` are the torn unknowns when the motor is switched on; ``unknowns_over_angle`` of shape
    (len(angle), unknowns) those over one revolution, ``angle`` [rad] increasing from 0 to 2 pi.
    """

    name: str
    states: list[str]
    unknowns: list[str]
    state_nominals: list[float]
    unknown_nominals: list[float]
    inputs: list[str]
    supply: float
    parameters: list[Parameter]
    dependent: int
    held: dict[str, float]
    watched: list[Watched]
    at_rest: list[float]
    angle: list[float]
    unknowns_over_angle: list[list[float]]

    def write(self, path: Path) -> None:
        """Write it as JSON; :meth:`read` gets it back as it was."""
        path.write_text(json.dumps(asdict(self)), encoding="utf-8")

    @staticmethod
    def read(path: Path) -> Plant:
        """Read what :meth:`write` wrote."""
        values = json.loads(path.read_text(encoding="utf-8"))
        values["parameters"] = [Parameter(**each) for each in values["parameters"]]
        values["watched"] = [Watched(**each) for each in values["watched"]]
        return Plant(**values)


def plant_of(dae: Dae, kept: Path | None = None) -> Plant:
    """Run the plant with its own parameters, and describe it.

    Args:
        dae: its equations.
        kept: where the FMU for the run stays for the next time; see :func:`cosim.linear.observed`.

    Raises:
        InputError: it is none of the wiper drive, or it does not turn.
        BuildError: there is no C compiler, or it failed.
    """
    outputs = outputs_of(dae)
    with observed(dae, kept) as inside:
        channels = [Channel(("model", "duty"), [0.0], [1.0])]
        system = System([Component("model", inside.fmu, {})], channels=channels)
        result = simulate(system, stop=_STOP, output_interval=2e-3, tolerance=1e-8)
        supply = float(inside.inputs({})[SUPPLY])
        names = inside.columns
    x, z, d, c = (np.array([result.columns[f"model.{n}"] for n in names[kind]], dtype=float) for kind in "xzdc")
    turning = x[[s.name for s in dae.states].index("phi_crank")] / (2.0 * np.pi)
    steady = result.time >= _SETTLED
    first = np.ceil(turning[steady][0])
    if turning[-1] < first + 1.0:
        raise InputError(f"{dae.name} turns only {turning[-1]:.2f} times in {_STOP:g} s at full duty")
    middle = int(np.searchsorted(turning, first + 0.5))
    held = {s.symbol.name(): float(v) for s, v in zip(dae.discretes, d[:, middle], strict=True)}
    held |= {r.symbol.name(): float(v) for r, v in zip(dae.relations, c[:, middle], strict=True)}
    behind = symbols_behind(dae, ca.vertcat(dae.derivatives, dae.residuals, outputs))
    angle = np.linspace(0.0, 2.0 * np.pi, _ROWS)
    over = np.array([np.interp(angle, 2.0 * np.pi * (turning - first), row) for row in z]).T
    return Plant(
        name=dae.name,
        states=[s.name for s in dae.states],
        unknowns=[s.name for s in dae.torn],
        state_nominals=[s.nominal for s in dae.states],
        unknown_nominals=[s.nominal for s in dae.torn],
        inputs=[s.name for s in dae.inputs],
        supply=supply,
        parameters=[
            Parameter(p.scalar.name, p.scalar.declaration.unit or "1", dae.parameter_values[p.scalar.name],
                      p.scalar.declaration.type)
            for p in dae.parameters if p.independent
        ] + [Parameter(SUPPLY_DROP, "V", 0.0, "Real")],
        dependent=sum(not p.independent for p in dae.parameters),
        held=held,
        watched=[
            Watched(r.symbol.name(), r.text, r.strict, bool(held[r.symbol.name()]))
            for r in dae.relations if r.symbol.name() in behind
        ],
        at_rest=z[:, 0].tolist(),
        angle=angle.tolist(),
        unknowns_over_angle=over.tolist(),
    )  # fmt: skip

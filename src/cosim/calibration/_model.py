"""The plant's equations as functions of what is fitted, in one mode: forward running, with all relations held."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from cosim.dae import Dae
from cosim.dae.hybrid import SX
from cosim.dae.symbolic import substitute
from cosim.engine import Channel, Component, System, simulate
from cosim.errors import InputError
from cosim.fmu import catalogue
from cosim.fmu.exporter import compile_model
from cosim.linear import observed, symbols_behind

Array = NDArray[np.float64]

OUTPUTS = ("i_motor", "tau_crank")
"""What can be measured: motor current [A] and torque on the gear's output shaft [N.m]."""
_PLANT = "linkage"
_SETTLED = 3.0
"""The nominal run is looked at from this time [s] on, for a whole revolution at least."""
_NOMINAL_STOP = 12.0


@dataclass(frozen=True)
class Nominal:
    """A run with the nominal parameters at full duty: over the crank angle modulo a revolution, where it is steady.

    ``angle`` [rad] of shape (n,), increasing from 0 to 2 pi; ``current`` [A] of shape (n,); ``z`` of shape
    (n, torn unknowns), angles that turn with the crank as differences to it.
    """

    angle: Array
    current: Array
    z: Array


class Model:
    """Right-hand sides of a plant with some parameters free.

    ``rhs(x, z, u, theta)`` gives dx/dt, the residuals 0 = r and the OUTPUTS; theta are the fitted parameters over
    their nominal values, of the same size where these are zero.
    """

    def __init__(
        self, dae: Dae, names: Sequence[str], given: Mapping[str, float] | None = None, kept: Path | None = None
    ) -> None:
        """Hold the relations as they are in steady forward running.

        Args:
            dae: the plant's equations.
            names: the parameters to fit.
            given: values of other parameters, and starting values of those to fit, in the model's units.
            kept: where the FMU for the nominal run stays for the next time; see :func:`cosim.linear.observed`.

        Raises:
            InputError: there is no such parameter, or it cannot be fitted.
            BuildError: there is no C compiler, or it failed.
        """
        given = given or {}
        self.dae = dae
        self.names = tuple(names)
        independent = {p.scalar.name: p for p in dae.parameters if p.independent}
        for name in (*names, *given):
            if name not in independent:
                near = get_close_matches(name, list(independent), n=3)
                hint = f"; did you mean {' or '.join(near)}?" if near else ""
                raise InputError(f"{dae.name} has no parameter '{name}'{hint}")
        for name in names:
            if independent[name].scalar.declaration.type != "Real":
                raise InputError(f"{name} is a {independent[name].scalar.declaration.type}; only Reals can be fitted")
        self.units = tuple(independent[name].scalar.declaration.unit or "1" for name in names)
        values = {name: given.get(name, dae.parameter_values[name]) for name in independent}
        self.start = np.array([values[name] for name in names])
        self.scale = np.where(self.start == 0.0, 1.0, self.start)
        fixed = {name: value for name, value in values.items() if name not in names}
        self.values = values
        self._given = {name: value for name, value in values.items() if value != dae.parameter_values[name]}
        self.nominal, d, c = self._run(kept)
        self.rhs, self.relations = self._functions(fixed, d, c)

    @property
    def sizes(self) -> tuple[int, int]:
        """How many states and torn unknowns there are."""
        return len(self.dae.states), len(self.dae.torn)

    @property
    def scales(self) -> tuple[Array, Array]:
        """Nominal sizes of the states and the torn unknowns."""
        return np.array([s.nominal for s in self.dae.states]), np.array([z.nominal for z in self.dae.torn])

    def state(self, name: str) -> int:
        """Return the position of a state."""
        return [s.name for s in self.dae.states].index(name)

    def input_column(self, supply: Array) -> Array:
        """Return the inputs for these supply voltages [V], shape (inputs, n): full duty, no disturbance."""
        rows = {"duty": np.ones(len(supply)), "v_supply": supply}
        return np.array([rows.get(s.name, np.zeros(len(supply))) for s in self.dae.inputs])

    def first_change(self, x: Array, z: Array, u: Array, theta: Array) -> tuple[int, str] | None:
        """Return the first column at which a relation is not as it is held, and its text; None if there is none."""
        held = self._watched
        if not held:
            return None
        values = np.array(self.relations.map(x.shape[1])(x, z, u, ca.repmat(theta, 1, x.shape[1])), dtype=np.float64)
        true = np.array([row > 0.0 if strict else row >= 0.0 for row, (_, strict, _) in zip(values, held, strict=True)])
        changed = true != np.array([value for _, _, value in held])[:, None]
        if not changed.any():
            return None
        column = int(np.argmax(changed.any(axis=0)))
        return column, held[int(np.argmax(changed[:, column]))][0]

    def _run(self, kept: Path | None) -> tuple[Nominal, dict[str, float], dict[str, float]]:
        """Run with the nominal parameters; return what is steady, and the discrete variables and relations there."""
        with observed(self.dae, kept) as inside:
            component = Component("model", inside.fmu, dict(self._given))
            channels = [Channel(("model", "duty"), [0.0], [1.0])]
            result = simulate(
                System([component], channels=channels), stop=_NOMINAL_STOP, output_interval=2e-3, tolerance=1e-8
            )
            names = inside.columns
        columns = {kind: [result.columns[f"model.{name}"] for name in names[kind]] for kind in "xzdc"}
        x, z = np.array(columns["x"], dtype=float), np.array(columns["z"], dtype=float)
        steady = result.time >= _SETTLED
        angle = x[self.state("phi_crank")]
        turning = angle[steady] / (2.0 * np.pi)
        if turning[-1] - turning[0] < 1.0:
            raise InputError(
                f"with the starting values the crank turns only {turning[-1] - turning[0]:.2f} times in "
                f"{_NOMINAL_STOP - _SETTLED:g} s; start from values with which the motor runs"
            )
        first = np.floor(turning[0]) + 1.0 if turning[0] % 1.0 else turning[0]
        turn = steady & (angle / (2 * np.pi) >= first) & (angle / (2 * np.pi) <= first + 1.0)
        nominal = Nominal(
            angle[turn] - 2.0 * np.pi * first,
            np.array(result.columns["model.i_motor"], dtype=float)[turn],
            z[:, turn].T,
        )
        middle = int(np.flatnonzero(turn)[np.count_nonzero(turn) // 2])
        d = {s.name: float(v[middle]) for s, v in zip(self.dae.discretes, columns["d"], strict=True)}
        c = {r.symbol.name(): float(v[middle]) for r, v in zip(self.dae.relations, columns["c"], strict=True)}
        return nominal, d, c

    def _functions(
        self, fixed: Mapping[str, float], d: Mapping[str, float], c: Mapping[str, float]
    ) -> tuple[ca.Function, ca.Function]:
        dae = self.dae
        theta = SX.sym("theta", len(self.names))
        held: dict[str, SX] = {s.symbol.name(): SX(d[s.name]) for s in dae.discretes}
        held |= {name: SX(value) for name, value in c.items()}
        held[dae.initial.name()] = SX(0.0)
        parameters: dict[str, SX] = {name: SX(value) for name, value in fixed.items()}
        parameters |= {name: theta[k] * self.scale[k] for k, name in enumerate(self.names)}
        for parameter in dae.parameters:
            name = parameter.scalar.name
            if name not in parameters:
                parameters[name] = substitute(parameter.value, parameters)
        held |= parameters
        arguments = [_column([s.symbol for s in dae.states]), dae.z, _column([s.symbol for s in dae.inputs]), theta]
        published = {p.scalar.name: p.value for p in dae.published}
        missing = [name for name in OUTPUTS if name not in published]
        if missing:
            raise InputError(
                f"{dae.name} has no variable {' and '.join(missing)}; a plant of the wiper drive is needed"
            )
        outputs = _column([published[name] for name in OUTPUTS])
        expressions = [substitute(e, held) for e in (dae.derivatives, dae.residuals, outputs)]
        behind = symbols_behind(dae, _column([dae.derivatives, dae.residuals, outputs]))
        watched = [r for r in dae.relations if r.symbol.name() in behind]
        self._watched = [(r.text, r.strict, bool(c[r.symbol.name()])) for r in watched]
        indicators = substitute(_column([r.indicator for r in watched]), held)
        free = ca.symvar(ca.vertcat(*expressions, indicators))
        extra = {s.name() for s in free} - {s.name() for a in arguments for s in ca.symvar(a)}
        if extra:
            raise InputError(f"{dae.name} depends on {', '.join(sorted(extra))} in a way that cannot be fitted")
        return ca.Function("rhs", arguments, expressions), ca.Function("relations", arguments, [indicators])


def linkage_equations() -> Dae:
    """Return the equations of the built-in plant with the linkage. Raises ModelError if they cannot be compiled."""
    entry = catalogue.entry_of(_PLANT)
    return compile_model(entry.source, entry.model)


def linkage_model(names: Sequence[str], given: Mapping[str, float] | None = None, dae: Dae | None = None) -> Model:
    """Return the built-in plant with the linkage, with some parameters free; arguments and errors as of Model.

    ``dae`` are its equations, if they are at hand.
    """
    return Model(dae or linkage_equations(), names, given, catalogue.scratch(_PLANT, "observed"))


def _column(values: Sequence[SX]) -> SX:
    return ca.vertcat(SX(0, 1), *values)

"""From a Modelica model to its linear system at an operating point."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Literal, Self

import numpy as np

from cosim.dae import Dae
from cosim.dae.dae import Published
from cosim.errors import InputError, SimulationError
from cosim.fmu.exporter import compile_model
from cosim.linear._equations import Blocks, Equations, Point, Vector, on_surface, with_unknowns
from cosim.linear._operating_point import Given, Observed, observed
from cosim.linear._steady import check_steady, steady_state
from cosim.linear._system import LinearSystem, Signal, per_second


def linearize(
    file: Path,
    model: str,
    *,
    at: float | Literal["initial", "steady"] = "initial",
    parameters: Given | None = None,
    inputs: Given | None = None,
    outputs: Collection[str] | None = None,
    steady_except: Sequence[str] = (),
    settle: float | None = None,
) -> LinearSystem:
    """Linearize a class of a Modelica file or package once; see `Linearizer.at` for arguments and errors."""
    with Linearizer(file, model) as linearizer:
        return linearizer.at(
            at,
            parameters=parameters,
            inputs=inputs,
            outputs=outputs,
            steady_except=steady_except,
            settle=settle,
        )


class Linearizer:
    """A compiled model that is linearized at one operating point after the other; a context manager.

    Its FMU is built when the first operating point is asked for, and removed in the end.
    """

    def __init__(self, file: Path, model: str) -> None:
        """Compile a class of a ``.mo`` file or package folder.

        Raises:
            ModelError: the model is wrong.
            InputError: it is discrete, so there is nothing to linearize.
        """
        self._dae = compile_model(file, model)
        self._resources = ExitStack()
        self._observed: Observed | None = None
        if not self._dae.unknowns and (self._dae.clocks or self._dae.discretes):
            raise InputError(
                f"{model} is discrete: it has no continuous state, its variables change at events only; "
                "linearize the model of a plant"
            )

    def __enter__(self) -> Self:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Remove the FMU."""
        self._observed = None
        self._resources.close()

    def at(
        self,
        moment: float | Literal["initial", "steady"] = "initial",
        *,
        parameters: Given | None = None,
        inputs: Given | None = None,
        outputs: Collection[str] | None = None,
        steady_except: Sequence[str] = (),
        settle: float | None = None,
    ) -> LinearSystem:
        """Linearize at an operating point, by the exact derivatives of the equations.

        Discrete variables and relations keep the values that they have at the operating point.

        Args:
            moment: "initial", the state after initialisation; a time [s] to which the model is simulated with constant
                inputs; or "steady", the state in which nothing changes.
            parameters: values that differ from the model's: numbers in the model's units, or texts with a unit.
            inputs: values of the inputs; the others have their start values.
            outputs: names of variables that become the outputs, instead of the model's outputs.
            steady_except: states that keep their value in the search of the steady state and need not be steady.
            settle: how long to simulate before that search [s]; by default 0, 1, 10 and 100 s are tried.

        Raises:
            InputError: there is no such input, parameter or output, there is no steady state, or an event is at the
                operating point.
            SimulationError: the simulation to the operating point, or the search of the steady state, failed.
            BuildError: there is no C compiler, or it failed.
        """
        if not isinstance(moment, str) and not (np.isfinite(moment) and moment >= 0):
            raise InputError(f"no model can be linearized at t = {moment} s; give a time from 0 on, initial or steady")
        dae = self._dae
        chosen = _outputs(dae, outputs)
        equations = Equations(dae, chosen)
        if moment == "steady":
            check_steady(equations, steady_except)
        if self._observed is None:
            self._observed = self._resources.enter_context(observed(dae))
        telling = self._observed
        set_values, all_inputs = telling.parameters(parameters or {}), telling.inputs(inputs or {})

        def simulated(time: float) -> Point:
            return _consistent(equations, telling.at(time, set_values, all_inputs))

        if moment == "steady":
            point = steady_state(equations, simulated, steady_except, settle)
        else:
            point = simulated(0.0 if moment == "initial" else float(moment))
        if surfaces := on_surface(equations, point):
            raise InputError(
                f"{dae.name} cannot be linearized here: '{surfaces[0]}' switches exactly at this operating point, "
                "where no derivative exists; take another time or another value of an input"
            )
        numbers = {name: float(value) for name, value in set_values.items() if not isinstance(value, str)}
        return _system(equations, chosen, point, moment if isinstance(moment, str) else f"{moment:g} s", numbers)


def _outputs(dae: Dae, wanted: Collection[str] | None) -> list[Published]:
    reals = {p.scalar.name: p for p in dae.published if p.scalar.type == "Real"}
    if wanted is None:
        return [p for p in reals.values() if p.scalar.causality == "output"]
    for name in wanted:
        if name not in reals:
            from difflib import get_close_matches

            near = get_close_matches(name, reals, n=3)
            hint = f"did you mean {' or '.join(near)}?" if near else "cosim info shows the variables of its FMU"
            raise InputError(f"{dae.name} has no Real variable '{name}' that could be an output; {hint}")
    return [reals[name] for name in wanted]


def _consistent(equations: Equations, point: Point) -> Point:
    """Let Newton's method take the solver's error out of the torn unknowns."""
    for _ in range(5):
        blocks = equations.blocks(point)
        if not len(point.z):
            break
        point = with_unknowns(point, point.x, point.z - _solve(equations.dae, blocks, blocks.r))
    return point


def _solve(dae: Dae, blocks: Blocks, right: Vector) -> Vector:
    try:
        solution: Vector = np.linalg.solve(blocks.r_z, right).astype(float)
    except np.linalg.LinAlgError:
        solution = np.full_like(right, np.nan)
    if not np.isfinite(solution).all():
        raise SimulationError(
            f"{dae.name}: the algebraic equations for {', '.join(u.name for u in dae.torn)} are singular at the "
            "operating point, so they give no linear model; take another operating point"
        )
    return solution


def _system(
    equations: Equations, outputs: Sequence[Published], point: Point, at: str, parameters: dict[str, float]
) -> LinearSystem:
    dae = equations.dae
    blocks = equations.blocks(point)
    # implicit function theorem: dz/dx = -r_z^-1 r_x, dz/du = -r_z^-1 r_u
    z_x, z_u = -_solve(dae, blocks, blocks.r_x), -_solve(dae, blocks, blocks.r_u)
    real = [k for k, s in enumerate(dae.inputs) if s.type == "Real"]
    units = {
        p.value.name(): p.scalar.declaration.unit
        for p in dae.published
        if p.value.is_symbolic() and p.scalar.declaration.unit
    }
    states = tuple(
        Signal(u.name, _state_unit(u.symbol.name(), units), float(value))
        for u, value in zip(dae.states, point.x, strict=True)
    )
    inputs = tuple(Signal(s.name, s.declaration.unit or "1", float(point.u[k])) for k, s in enumerate(dae.inputs))
    discretes = [(dae.discretes[k].name, float(point.d[k])) for k in equations.held]
    held = {name: value for name, value in discretes if name[0] != "$"}
    held |= {signal.name: signal.value for k, signal in enumerate(inputs) if k not in real}
    return LinearSystem(
        model=dae.name,
        at=at,
        time=point.time,
        states=states,
        inputs=tuple(inputs[k] for k in real),
        outputs=tuple(
            Signal(o.scalar.name, o.scalar.declaration.unit or "1", float(value))
            for o, value in zip(outputs, blocks.h, strict=True)
        ),
        A=blocks.f_x + blocks.f_z @ z_x,
        B=(blocks.f_u + blocks.f_z @ z_u)[:, real],
        C=blocks.h_x + blocks.h_z @ z_x,
        D=(blocks.h_u + blocks.h_z @ z_u)[:, real],
        slope=blocks.f,
        held=held,
        parameters=parameters,
    )


def _state_unit(name: str, units: dict[str, str]) -> str:
    """The unit of a state; of a derivative without name of its own from what it is the derivative of."""
    if name in units or not name.startswith("der("):
        return units.get(name, "1")
    return per_second(_state_unit(name[4:-1], units))

"""The steady state: where all derivatives vanish, found by Newton's method from a simulated point."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.errors import InputError, SimulationError
from cosim.linear._equations import Blocks, Equations, Point, Vector, beyond_surface, with_unknowns

_ITERATIONS = 60
_CONVERGED = 1e-11
_SINGULAR = 1e-12
_ATTEMPTS = (0.0, 1.0, 10.0, 100.0)
"""Times [s] to which the model is simulated, one after the other, until Newton's method succeeds from there."""


def check_steady(equations: Equations, excepted: Sequence[str]) -> None:
    """Raise `InputError` for a model that cannot have a steady state, or a name that is no state."""
    name = equations.dae.name
    if equations.depends_on_time:
        raise InputError(f"{name} depends on time, so it has no steady state; linearize it at a time instead")
    if equations.sampled:
        raise InputError(
            f"{name} has parts that change at sample times, which have no derivative, so its steady state is not "
            "sought; linearize it at a time, or the plant alone"
        )
    names = [state.name for state in equations.dae.states]
    unknown = [state for state in excepted if state not in names]
    if unknown:
        raise InputError(f"{name} has no state '{unknown[0]}'; its states are {', '.join(names) or 'none'}")


def steady_state(
    equations: Equations, simulated: Callable[[float], Point], excepted: Sequence[str], settle: float | None
) -> Point:
    """Return the steady state.

    Args:
        equations: the model, which `check_steady` has passed.
        simulated: gives the point at a time [s].
        excepted: states that keep the value they have at the start of the search, and need not be steady.
        settle: simulate this long first [s]; by default several times are tried.

    Raises:
        InputError: states that are integrators, or otherwise cannot be steady together; the message names them.
        SimulationError: Newton's method does not converge, or only beyond an event.
    """
    name = equations.dae.name
    names = [state.name for state in equations.dae.states]
    free = np.array([state not in excepted for state in names], dtype=bool)
    reasons: list[str] = []
    starts: list[Point] = []
    for time in _ATTEMPTS if settle is None else (settle,):
        try:
            starts.append(simulated(time))
        except SimulationError as error:
            if not starts:
                raise
            reasons.append(str(error))
            starts.clear()  # what runs away is no integrator
            break
        found = _Search(equations, free).run(starts[-1])
        if found.reason is None:
            return found.point
        if found.integrators:
            raise InputError(_integrator(name, found.integrators, excepted, "nothing determines {}"))
        reasons.append(f"from t = {time:g} s: {found.reason}")
    if drifting := tuple(names[k] for k in _drifting(equations, starts) if free[k]):
        raise InputError(_integrator(name, drifting, excepted, "{} would move on and on"))
    remedy = "simulate closer to it with --settle, except a state with --steady-except, or linearize at a time"
    raise SimulationError(f"{name}: no steady state was found ({'; '.join(reasons)}); {remedy}")


@dataclass(frozen=True)
class _Found:
    point: Point
    reason: str | None = None
    integrators: tuple[str, ...] = ()


def _integrator(name: str, integrators: Sequence[str], excepted: Sequence[str], what: str) -> str:
    options = " ".join(f"--steady-except {state}" for state in [*excepted, integrators[0]])
    return (
        f"{name} has no steady state: {what.format(', '.join(integrators))}; such a state is an integrator, like the "
        f"angle of a shaft that turns. Let it keep its value: {options}"
    )


def _drifting(equations: Equations, starts: Sequence[Point]) -> list[int]:
    """States that between the last two points moved about as far as their speed there would take them."""
    if len(starts) < 2:
        return []
    before, after = starts[-2:]
    speed = np.maximum(np.abs(equations.blocks(before).f), np.abs(equations.blocks(after).f))
    moved = np.abs(after.x - before.x)
    nominal = np.array([state.nominal for state in equations.dae.states])
    far = moved > 1e-3 * np.maximum(np.abs(after.x), nominal)
    return [int(k) for k in np.flatnonzero(far & (moved > 0.5 * speed * (after.time - before.time)))]


class _Search:
    """Newton's method with damping, on the derivatives of the free states and the algebraic residuals."""

    def __init__(self, equations: Equations, free: NDArray[np.bool_]) -> None:
        self._equations = equations
        self._free = free
        self._nominal = np.array([u.nominal for u in equations.dae.unknowns])

    def run(self, start: Point) -> _Found:
        point, blocks = start, self._equations.blocks(start)
        for _ in range(_ITERATIONS):
            value, jacobian = self._system(blocks)
            scale = self._scale(point)
            rows = np.abs(jacobian * scale).max(axis=1, initial=0.0)
            if not (np.isfinite(value).all() and np.isfinite(jacobian).all()):
                return _Found(point, "the equations have no finite value there")
            # the least-squares step stays defined where an integrator makes the Jacobian singular
            weight = np.where(rows > 0, rows, 1.0)
            step, *_ = np.linalg.lstsq(jacobian * scale / weight[:, None], -value / weight, rcond=1e-13)
            size = float(np.linalg.norm(value / weight))
            point, blocks, moved = self._damped(point, blocks, step * scale, size, weight)
            if moved < _CONVERGED or not moved:
                break
        return self._judge(point, blocks)

    def _damped(
        self, point: Point, blocks: Blocks, step: Vector, size: float, weight: Vector
    ) -> tuple[Point, Blocks, float]:
        """Take the longest part of a step that makes the residual smaller; also how far that is."""
        for halvings in range(30):
            part = step * 0.5**halvings
            new = self._moved(point, part)
            there = self._equations.blocks(new)
            value, _ = self._system(there)
            with np.errstate(invalid="ignore", over="ignore"):
                smaller = float(np.linalg.norm(value / weight)) <= size * (1 - 1e-4 * 0.5**halvings)
            if smaller or size == 0.0:
                return new, there, float(np.abs(part / self._scale(new)).max(initial=0.0))
        return point, blocks, 0.0

    def _judge(self, point: Point, blocks: Blocks) -> _Found:
        value, jacobian = self._system(blocks)
        scale = self._scale(point)
        rows = np.abs(jacobian * scale).max(axis=1, initial=0.0)
        error = np.abs(value) / np.where(rows > 0, rows, 1.0)
        if error.max(initial=0.0) < 1e-9:
            beyond = beyond_surface(self._equations, point)
            return _Found(point, f"it lies where '{beyond[0]}' has switched" if beyond else None)
        names = [u.name for u, free in zip(self._equations.dae.unknowns, self._kept(), strict=True) if free]
        count = int(self._free.sum())
        if found := self._integrators(point):
            return _Found(point, "singular", tuple(names[k] for k in found))
        worst = int(np.argmax(error))
        what = f"der({names[worst]})" if worst < count else f"the equation for {names[worst]}"
        return _Found(point, f"Newton's method stops with {what} = {value[worst]:.3g}")

    def _integrators(self, point: Point) -> list[int]:
        """Positions of free states that no equation determines, whatever the point: here and beside it."""
        scale = self._scale(point)
        random = np.random.default_rng(20180601)
        undetermined = np.ones(len(scale), dtype=bool)
        for part in (0.0, 1e-3, 1e-3, 1e-2):
            beside = self._moved(point, part * scale * random.uniform(-1, 1, len(scale)))
            _, jacobian = self._system(self._equations.blocks(beside))
            scaled = jacobian * scale
            rows = np.abs(scaled).max(axis=1, initial=0.0)
            if not np.isfinite(scaled).all():
                return []
            _, sizes, right = np.linalg.svd(scaled / np.where(rows > 0, rows, 1.0)[:, None])
            null = right[sizes <= _SINGULAR * sizes.max(initial=0.0)]
            undetermined &= np.abs(null).max(axis=0, initial=0.0) > 1e-3
        return [int(k) for k in np.flatnonzero(undetermined[: int(self._free.sum())])]

    def _kept(self) -> NDArray[np.bool_]:
        return np.concatenate([self._free, np.ones(len(self._equations.dae.torn), dtype=bool)])

    def _scale(self, point: Point) -> Vector:
        unknowns = np.concatenate([point.x, point.z])
        scale: Vector = np.maximum(np.abs(unknowns), self._nominal)[self._kept()]
        return scale

    def _system(self, blocks: Blocks) -> tuple[Vector, Vector]:
        free = self._free
        value = np.concatenate([blocks.f[free], blocks.r])
        upper = np.hstack([blocks.f_x[np.ix_(free, free)], blocks.f_z[free]])
        return value, np.vstack([upper, np.hstack([blocks.r_x[:, free], blocks.r_z])])

    def _moved(self, point: Point, step: Vector) -> Point:
        count = int(self._free.sum())
        x = point.x.copy()
        x[self._free] += step[:count]
        return with_unknowns(point, x, point.z + step[count:])

"""The plant under inputs that are constant between steps, integrated by SciPy to a tight tolerance."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp

from .plant import Plant

Array = NDArray[np.float64]
Signal = float | Sequence[tuple[float, float]]
"""A constant, or (time, value) pairs in the order of time, each value held until the next; before the first, 0."""
Method = Literal["DOP853", "RK45", "Radau", "LSODA", "BDF"]


@dataclass
class Hold:
    """A signal that holds its value between steps."""

    times: list[float]
    values: list[float]

    @classmethod
    def of(cls, signal: Signal) -> Hold:
        """From a constant or (time, value) pairs."""
        if isinstance(signal, (int, float)):
            return cls([-np.inf], [float(signal)])
        return cls([-np.inf, *(t for t, _ in signal)], [0.0, *(float(v) for _, v in signal)])

    def at(self, t: float) -> float:
        """Value after the steps at t."""
        return self.values[bisect_right(self.times, t) - 1]

    def before(self, t: float) -> float:
        """Value that led to t."""
        return self.values[max(bisect_left(self.times, t) - 1, 0)]

    def steps(self, start: float, stop: float) -> list[float]:
        """Instants of the steps strictly between start and stop."""
        return [t for t in self.times if start < t < stop]


def simulate(
    plant: Plant,
    duty: Signal,
    t_eval: ArrayLike,
    *,
    v_supply: Signal = 28.0,
    tau_disturbance: Signal = 0.0,
    initial: tuple[float, float, float] = (0.0, 0.0, 0.0),
    rtol: float = 1e-12,
    atol: float = 1e-14,
    method: Method = "DOP853",
    max_step: float = 1e-3,
    energy: bool = False,
) -> dict[str, Array]:
    """Integrate from ``t_eval[0]`` with the state ``initial`` = (i [A], phi [rad], w [rad/s]).

    Returns the outputs of the FMU interface at ``t_eval`` under their names, with ``time``; at the instant of an input
    step the outputs that feed an input through still show the value that led there, at the first instant the one
    after. With ``energy``, also ``work_<name>`` [J] for each of :meth:`Plant.powers` and ``stored_energy`` [J].
    The integration restarts at every input step and whenever the diode begins or ends to conduct.
    """
    times = np.asarray(t_eval, dtype=float)
    inputs = Hold.of(duty), Hold.of(v_supply), Hold.of(tau_disturbance)
    start, stop = float(times[0]), float(times[-1])
    steps = sorted({t for signal in inputs for t in signal.steps(start, stop)})
    works = list(plant.powers(*initial, 0.0, 0.0)) if energy else []

    state: Array = np.array([*initial, *(0.0 for _ in works)])
    states = np.empty((len(state), len(times)))
    states[:, 0] = state
    for begin, end in pairwise([start, *steps, stop]):
        drive = inputs[0].at(begin) * inputs[1].at(begin)
        torque = inputs[2].at(begin)
        t = begin
        conducting = plant.conducts(state[0], state[2], drive)
        while t < end:
            rows = np.flatnonzero((times > t) & (times <= end))
            solution = solve_ivp(
                _right_side(plant, drive, torque, conducting, energy),
                (t, end),
                state,
                method=method,
                dense_output=True,
                events=_switch(plant, drive, conducting),
                rtol=rtol,
                atol=atol,
                max_step=max_step,
            )
            if solution.status < 0:
                raise RuntimeError(f"The reference integration stopped at t = {solution.t[-1]} s: {solution.message}")
            t = float(solution.t[-1])
            rows = rows[times[rows] <= t]
            if rows.size and solution.sol is not None:
                states[:, rows] = solution.sol(times[rows])
            state = solution.y[:, -1].copy()
            if solution.status == 1:
                if conducting:
                    state[0] = 0.0
                conducting = not conducting
    return _table(plant, times, states, inputs, works)


def _table(
    plant: Plant, times: Array, states: Array, inputs: tuple[Hold, Hold, Hold], works: list[str]
) -> dict[str, Array]:
    duty, supply, torque = inputs
    rows = []
    for column, t in enumerate(times):
        # The values that led to t; at the first instant, those that hold from there.
        ratio, voltage, disturbance = (hold.at(t) if column == 0 else hold.before(t) for hold in (duty, supply, torque))
        i, phi, w = (float(x) for x in states[:3, column])
        rows.append(plant.outputs(i, phi, w, ratio * voltage, disturbance))
    table = {"time": times, **{name: np.array([row[name] for row in rows]) for name in rows[0]}}
    if works:
        table |= {f"work_{name}": states[3 + n] for n, name in enumerate(works)}
        table["stored_energy"] = np.array([plant.stored_energy(*map(float, y[:3])) for y in states.T])
    return table


def _right_side(
    plant: Plant, drive: float, torque: float, conducting: bool, energy: bool
) -> Callable[[float, Array], list[float]]:
    def motion(_t: float, y: Array) -> list[float]:
        i, phi, w = y.tolist()
        rates = plant.rates(i, phi, w, drive, torque, conducting=conducting)
        return [rates.di, w, rates.dw]

    def motion_and_work(_t: float, y: Array) -> list[float]:
        i, phi, w = y[:3].tolist()
        rates = plant.rates(i, phi, w, drive, torque, conducting=conducting)
        return [rates.di, w, rates.dw, *plant.powers(i, phi, w, drive, torque).values()]

    return motion_and_work if energy else motion


def _switch(plant: Plant, drive: float, conducting: bool) -> Callable[[float, Array], float]:
    # A value of exactly zero, as at rest, is no crossing: the smallest amount keeps it on the side of its mode.
    def current(_t: float, y: Array) -> float:
        return float(y[0]) + 1e-300

    def forward_voltage(_t: float, y: Array) -> float:
        return drive - plant.back_emf(float(y[2])) - 1e-300

    switch = current if conducting else forward_voltage
    switch.terminal = True  # type: ignore[attr-defined]
    switch.direction = -1 if conducting else 1  # type: ignore[attr-defined]
    return switch

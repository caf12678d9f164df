"""Plant and controller together, with the chart's instants as stops.

At t_k = k T_compute the controller reads the plant's outputs at t_k, and its duty acts on the plant from t_k on. In
between, the plant's three states follow Dormand and Prince's pair of orders 5 and 4 (Hairer, Norsett, Wanner, Solving
Ordinary Differential Equations I, table II.5.2), written out for speed, with restarts at every tick, at input
steps and where the diode begins or ends to conduct. It shares only the right-hand side with ``simulation``, which
checks it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from .controller import Controller, Outputs, Parameters, State
from .plant import Plant, on_park
from .simulation import Hold, Signal

Array = NDArray[np.float64]
Sensed = Callable[[int, float, bool], tuple[float, bool]]
"""What the controller sees of current and contact, from the tick's number and what they are."""
Triple = tuple[float, float, float]
RightSide = Callable[[float, float, float], Triple]


@dataclass
class ClosedLoop:
    """Trajectories at the ticks and what the chart did."""

    values: dict[str, Array]
    """``time``, the plant's outputs, ``duty``, ``i_filtered``, ``i_limit``, ``period``, ``i_real``.

    Plant outputs that feed an input through (v_motor, tau_crank) show the end of the step that led to the tick; the
    controller's outputs hold from the tick on.
    """
    states: list[State]
    """The chart's state from each tick on."""
    changes: list[tuple[float, State]]
    """(time, state entered), the first at tick 0; IDLE passed through within one tick does not count."""
    steps: int = 0
    """Integration steps taken."""


def closed_loop(
    plant: Plant,
    parameters: Parameters | None = None,
    *,
    stop: float,
    v_supply: Signal = 28.0,
    tau_disturbance: Signal = 0.0,
    enable: Signal = 1.0,
    initial: Triple = (0.0, 0.0, 0.0),
    rtol: float = 1e-10,
    atol: float = 1e-12,
    sensed: Sensed = lambda k, current, park: (current, park),
) -> ClosedLoop:
    """Run from t = 0 to ``stop`` [s], a multiple of T_compute; the tick at ``stop`` is computed too.

    Signals as for :func:`.simulation.simulate`; a step of an input that coincides with a tick (within 1e-9 s) acts from
    that tick on, and ``enable`` is read there after its step. ``sensed`` is called once for each tick, in their order.
    """
    parameters = parameters or Parameters()
    controller = Controller(parameters)
    supply, torque, switch = Hold.of(v_supply), Hold.of(tau_disturbance), Hold.of(enable)
    count = parameters.ticks(stop)
    integrator = _Integrator(plant, rtol, atol)
    state = initial
    rows: list[dict[str, float]] = []
    states: list[State] = []
    changes: list[tuple[float, State]] = []
    drive: float | None = None
    guard = 1e-9
    for k in range(count + 1):
        t = k * parameters.T_compute
        current, park = sensed(k, state[0], on_park(state[1]))
        out = controller.step(t, current, park, switch.at(t + guard) != 0.0)
        if drive is None:
            drive = out.duty * supply.at(t + guard)
        row = plant.outputs(*state, drive, torque.before(t - guard) if k else torque.at(t + guard))
        rows.append({"time": t} | row | _controller_row(out))
        if not states or out.state is not states[-1]:
            changes.append((t, out.state))
        states.append(out.state)
        if k == count:
            break
        end = (k + 1) * parameters.T_compute
        inner = [x for s in (supply, torque) for x in s.steps(t + guard, end - guard)]
        stops = [t, *sorted(set(inner)), end]
        for begin, finish in pairwise(stops):
            drive = out.duty * supply.at(begin + guard)
            state = integrator.advance(state, finish - begin, drive, torque.at(begin + guard))
    values = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    return ClosedLoop(values, states, changes, integrator.steps)


def _controller_row(out: Outputs) -> dict[str, float]:
    return {
        "duty": out.duty,
        "i_filtered": out.i_filtered,
        "i_limit": out.i_limit,
        "period": out.period,
        "i_real": out.i_real,
    }


class _Integrator:
    """Adaptive steps over one interval of constant inputs."""

    def __init__(self, plant: Plant, rtol: float, atol: float) -> None:
        self.plant, self.rtol, self.atol = plant, rtol, atol
        self.steps = 0
        self._h = 1e-4

    def advance(self, state: Triple, length: float, drive: float, torque: float) -> Triple:
        """The state after ``length`` seconds."""
        left = length
        smallest = 1e-12 * length
        while left > smallest:
            conducting = self.plant.conducts(state[0], state[2], drive)
            right_side, margin = self._right_side(drive, torque, conducting), self._margin(drive, conducting)
            slope = right_side(*state)
            while left > smallest:
                h = min(self._h, left)
                following, error = self._step(right_side, state, slope, h)
                factor = 0.9 * error**-0.2 if error > 1e-9 else 5.0
                if error > 1:
                    self._h = h * max(factor, 0.2)
                    continue
                self.steps += 1
                if h < left or factor < 1:
                    self._h = h * min(factor, 5.0)
                if margin(following) < 0:
                    h, state = self._to_switch(right_side, state, slope, h, margin)
                    left -= h
                    break
                state = following
                left -= h
                slope = right_side(*state)
        return state

    def _right_side(self, drive: float, torque: float, conducting: bool) -> RightSide:
        rates = self.plant.rates

        def right_side(i: float, phi: float, w: float) -> Triple:
            r = rates(i, phi, w, drive, torque, conducting=conducting)
            return r.di, w, r.dw

        return right_side

    def _margin(self, drive: float, conducting: bool) -> Callable[[Triple], float]:
        """Function of the state that is negative once the diode must switch."""
        if conducting:
            return lambda state: state[0]
        return lambda state: self.plant.back_emf(state[2]) - drive

    def _to_switch(
        self, right_side: RightSide, state: Triple, slope: Triple, h: float, margin: Callable[[Triple], float]
    ) -> tuple[float, Triple]:
        """Length of the step that ends where the diode switches, by bisection, and the state there."""
        low, high = 0.0, h
        for _ in range(60):
            middle = (low + high) / 2
            reached, _error = self._step(right_side, state, slope, middle)
            if margin(reached) < 0:
                high = middle
            else:
                low = middle
        reached, _error = self._step(right_side, state, slope, high)
        return high, (0.0, reached[1], reached[2])

    def _step(self, f: RightSide, y: Triple, k1: Triple, h: float) -> tuple[Triple, float]:
        """Order 5 and the largest error estimate in units of the tolerance."""
        y0, y1, y2 = y
        a0, a1, a2 = k1
        b0, b1, b2 = f(y0 + h * a0 / 5, y1 + h * a1 / 5, y2 + h * a2 / 5)
        c0, c1, c2 = f(*(x + h * (3 * a + 9 * b) / 40 for x, a, b in ((y0, a0, b0), (y1, a1, b1), (y2, a2, b2))))
        d0, d1, d2 = f(
            *(
                x + h * (44 / 45 * a - 56 / 15 * b + 32 / 9 * c)
                for x, a, b, c in ((y0, a0, b0, c0), (y1, a1, b1, c1), (y2, a2, b2, c2))
            )
        )
        e0, e1, e2 = f(
            *(
                x + h * (19372 / 6561 * a - 25360 / 2187 * b + 64448 / 6561 * c - 212 / 729 * d)
                for x, a, b, c, d in ((y0, a0, b0, c0, d0), (y1, a1, b1, c1, d1), (y2, a2, b2, c2, d2))
            )
        )
        stages = (y0, a0, b0, c0, d0, e0), (y1, a1, b1, c1, d1, e1), (y2, a2, b2, c2, d2, e2)
        g0, g1, g2 = f(
            *(
                x + h * (9017 / 3168 * a - 355 / 33 * b + 46732 / 5247 * c + 49 / 176 * d - 5103 / 18656 * e)
                for x, a, b, c, d, e in stages
            )
        )
        last = (g0, g1, g2)
        z0, z1, z2 = (
            x + h * (35 / 384 * a + 500 / 1113 * c + 125 / 192 * d - 2187 / 6784 * e + 11 / 84 * g)
            for (x, a, _b, c, d, e), g in zip(stages, last, strict=True)
        )
        k7 = f(z0, z1, z2)
        worst = 0.0
        for (x, a, _b, c, d, e), g, s, z in zip(stages, last, k7, (z0, z1, z2), strict=True):
            estimate = h * (
                71 / 57600 * a - 71 / 16695 * c + 71 / 1920 * d - 17253 / 339200 * e + 22 / 525 * g - s / 40
            )
            worst = max(worst, abs(estimate) / (self.atol + self.rtol * max(abs(x), abs(z))))
        return (z0, z1, z2), worst

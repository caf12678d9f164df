"""The part of a measurement that is fitted, and what it says of the motion before anything is fitted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.calibration._model import Model
from cosim.errors import InputError
from cosim.measurement import Measurement, zero_phase

Array = NDArray[np.float64]

_INRUSH = 0.3
"""The motor is switched on where the current first exceeds this part of its largest value."""
_AT_REST = 0.25
"""A window that begins with the current below this part of its mean value begins at rest."""


@dataclass(frozen=True)
class Data:
    """Samples to fit: ``time`` [s] and ``supply`` [V] of shape (n,); ``current`` [A] and ``torque`` [N.m] likewise.

    ``torque`` is None unless it was measured independently of the current. ``noise`` are their standard deviations.
    ``from_rest`` tells that the motor is switched on at the beginning.
    """

    name: str
    time: Array
    supply: Array
    current: Array
    torque: Array | None
    noise: tuple[float, float]
    from_rest: bool

    def supply_at(self, times: Array) -> Array:
        """Return the supply voltage at some instants, smoothed over 0.1 s."""
        length = max(3, round(0.1 / float(np.median(np.diff(self.time)))))
        return np.interp(times, self.time, zero_phase(self.supply, length))

    def guess(self, model: Model, start: float, points: Array) -> tuple[Array, Array]:
        """Return a guess of q = [x0; theta] and w at the collocation points, both scaled.

        The speed follows from the voltage that the current leaves for the motor; the angle is its integral, from where
        the current fits the nominal one best; everything else is as in the nominal run at that angle.
        """
        step = float(np.median(np.diff(self.time)))
        current = zero_phase(self.current, max(3, round(0.02 / step)))
        k, resistance, ratio = (_value(model, name) for name in ("k_emf", "motor.R", "gear.ratio"))
        inductance = _value(model, "motor.L") + 2.0 * _value(model, "motor.L_filter")
        emf = self.supply_at(self.time) - resistance * current - inductance * np.gradient(current, self.time)
        speed = np.maximum(emf / (k * ratio), 0.0)
        if self.from_rest:
            speed = np.where(self.time < self.time[0] + 0.004, 0.0, speed)
        angle = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(self.time))))
        angle += self._phase(model, angle, current)
        grid = np.concatenate(([start], points))
        phi, w, i = (np.interp(grid, self.time, values) for values in (angle, speed, current))
        nominal = model.nominal
        inside = np.mod(phi, 2.0 * np.pi)
        z = np.array([np.interp(inside, nominal.angle, column) for column in _unrolled(nominal.z.T)])
        z += _turns(nominal.z.T)[:, None] * (phi - inside)[None, :]
        x = np.zeros((model.sizes[0], len(grid)))
        x[model.state("phi_crank")], x[model.state("w_crank")], x[model.state("bridge.i")] = phi, w, i
        x_scale, z_scale = model.scales
        scaled = np.vstack((x / x_scale[:, None], z / z_scale[:, None]))
        theta = model.start / model.scale
        return np.concatenate((scaled[: model.sizes[0], 0], theta)), scaled[:, 1:].ravel(order="F")

    def _phase(self, model: Model, angle: Array, current: Array) -> float:
        """Return the crank angle [rad] at the first sample, from the current over the angle in steady running."""
        if self.from_rest:
            return 0.0
        count = 360
        candidates = 2.0 * np.pi * np.arange(count) / count
        nominal = model.nominal
        template = nominal.current - nominal.current.mean()
        seen = current - current.mean()
        scores = [
            float(np.interp(np.mod(angle + phase, 2.0 * np.pi), nominal.angle, template) @ seen) for phase in candidates
        ]
        return float(candidates[int(np.argmax(scores))])


def data_of(measurement: Measurement, start: float | None, stop: float | None, revolutions: float = 3.0) -> Data:
    """Cut out what is fitted: from where the motor is switched on, or ``start`` [s], to ``stop`` [s].

    The current is the instantaneous one if there is one, since the average is delayed. A torque counts only if it is
    not computed from the current, as that of the supplier's workbooks is. The default length is ``revolutions`` of
    about 2.3 s.

    Raises InputError if there is no current or voltage, or too little in the window.
    """
    source = measurement.meta["source"]
    for column in ("current", "voltage"):
        if not measurement.has(column):
            raise InputError(f"{source}: the {column} was not measured; current and voltage are needed to fit")
    instantaneous = "current_instantaneous" if measurement.has("current_instantaneous") else "current"
    time, current = measurement.values("time"), measurement.values(instantaneous)
    gaps = np.isnan(current)
    current = np.interp(time, time[~gaps], current[~gaps])
    on = int(np.argmax(current >= _INRUSH * current.max()))
    begin = time[on] if start is None else start
    end = begin + 2.3 * revolutions if stop is None else stop
    inside = (time >= begin - 1e-9) & (time <= end + 1e-9)
    if np.count_nonzero(inside) < 100:
        raise InputError(f"{source}: {np.count_nonzero(inside)} samples from {begin:g} s to {end:g} s; 100 are needed")
    supply = measurement.values("voltage")
    holes = np.isnan(supply)
    supply = np.interp(time, time[~holes], supply[~holes])
    torque = None
    if measurement.meta["torque_line"] is None and measurement.has("torque"):
        torque = measurement.values("torque")[inside]
    return Data(
        name=measurement.name,
        time=time[inside],
        supply=supply[inside],
        current=current[inside],
        torque=torque,
        noise=(_noise(current[inside]), _noise(torque) if torque is not None else 1.0),
        from_rest=start is None,
    )


def _noise(values: Array) -> float:
    """Standard deviation of white noise on a smooth signal: of second differences, robustly, over sqrt(6)."""
    second = np.diff(values, 2)
    deviation = 1.4826 * float(np.median(np.abs(second - np.median(second)))) / np.sqrt(6.0)
    return float(max(deviation, 1e-6 * float(np.ptp(values)), 1e-12))


def _value(model: Model, name: str) -> float:
    if name in model.names:
        return float(model.start[model.names.index(name)])
    return float(model.values[name])


def _turns(columns: Array) -> Array:
    """How many times each unknown turns with the crank."""
    return np.asarray(np.round((columns[:, -1] - columns[:, 0]) / (2.0 * np.pi)), dtype=np.float64)


def _unrolled(columns: Array) -> Array:
    """The unknowns over one revolution, those that turn with the crank from their value modulo one."""
    whole = 2.0 * np.pi * np.round(columns[:, :1] / (2.0 * np.pi)) * (_turns(columns)[:, None] != 0.0)
    return np.asarray(columns - whole, dtype=np.float64)

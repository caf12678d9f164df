"""The part of a measurement that is fitted, and what it says of the motion before anything is fitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cosim.calibration._equations import SUPPLY_DROP
from cosim.calibration._model import Model
from cosim.errors import InputError
from cosim.measurement import Measurement, zero_phase

Array = NDArray[np.float64]

_INRUSH = 0.3
"""The motor is switched on where the current first exceeds this part of its largest value."""
_LENGTH = 7.0
"""How much [s] is fitted unless something else is asked for: three revolutions or more."""
_SMOOTHED, _STARTED = 0.02, 0.1
"""The supply is smoothed over the former [s], but not for the latter [s] after a start, where it sags."""
_AFFINE = 1e-3
"""A torque that a straight line takes from the current to within this part of its deviation is computed from it."""
_FEWEST = 100


@dataclass(frozen=True)
class Data:
    """Samples to fit: ``time`` [s] and ``supply`` [V] of shape (n,); ``current`` [A] and ``torque`` [N.m] likewise.

    ``torque`` is None unless it was measured independently of the current. ``noise`` are their standard deviations.
    ``from_rest`` tells that the motor is switched on at the beginning, ``synthetic`` that the data were computed.
    """

    name: str
    time: Array
    supply: Array
    current: Array
    torque: Array | None
    noise: tuple[float, float]
    from_rest: bool
    synthetic: bool = False
    source: str = ""
    known: tuple[float, ...] | None = None
    """The initial state (crank angle, its speed, current) where it is known; it is fitted otherwise."""
    notes: tuple[str, ...] = ()

    @property
    def measured(self) -> list[tuple[Array, float]]:
        """Samples and noise of the OUTPUTS that were measured, in their order."""
        found = [(self.current, self.noise[0])]
        return found if self.torque is None else [*found, (self.torque, self.noise[1])]

    def supply_at(self, times: Array) -> Array:
        """Return the supply voltage at some instants, smoothed but for the start."""
        length = max(3, round(_SMOOTHED / float(np.median(np.diff(self.time)))))
        smooth = zero_phase(self.supply, length)
        if self.from_rest:
            share = np.clip((self.time - self.time[0]) / _STARTED - 1.0, 0.0, 1.0)
            smooth = share * smooth + (1.0 - share) * self.supply
        return np.interp(times, self.time, smooth)

    def initial(self, model: Model) -> Array:
        """Return a guess of the initial state: the known one, rest, or where the current fits the nominal one best."""
        if self.known is not None:
            return np.array(self.known, dtype=np.float64)
        first: Array = self._state(model, self.time[:1])[0]
        return first

    def guess(self, model: Model, start: float, points: Array) -> tuple[Array, Array]:
        """Return a guess of q = [x0; theta] and w at the collocation points, both scaled.

        The speed follows from the voltage that the current leaves for the motor; the angle is its integral, from where
        the current fits the nominal one best; everything else is as in the nominal run at that angle.
        """
        x = self._state(model, np.concatenate(([start], points)))
        z = model.unknowns(x[:, model.state("phi_crank")])
        x_scale, z_scale = model.scales
        q = np.concatenate((x[0] / x_scale, model.start / model.scale))
        return q, np.hstack((x[1:] / x_scale, z[1:] / z_scale)).ravel()

    def _state(self, model: Model, times: Array) -> Array:
        """Guess the states at some instants, shape (n, states)."""
        step = float(np.median(np.diff(self.time)))
        current = zero_phase(self.current, max(3, round(0.02 / step)))
        k, resistance, ratio, inductance = (model.values[n] for n in ("k_emf", "motor.R", "gear.ratio", "motor.L"))
        inductance += 2.0 * model.values["motor.L_filter"]
        supply = self.supply_at(self.time) - model.values[SUPPLY_DROP]
        emf = supply - resistance * current - inductance * np.gradient(current, self.time)
        speed = np.maximum(emf / (k * ratio), 0.0)
        if self.from_rest:
            speed = np.where(self.time < self.time[0] + 0.004, 0.0, speed)
        angle = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(self.time))))
        angle += self._phase(model, angle, current)
        x = np.zeros((len(times), model.sizes[0]))
        for name, values in {"phi_crank": angle, "w_crank": speed, "bridge.i": current}.items():
            x[:, model.state(name)] = np.interp(times, self.time, values)
        return x

    def _phase(self, model: Model, angle: Array, current: Array) -> float:
        """Return the crank angle [rad] at the first sample, from the current over the angle in steady running."""
        if self.from_rest:
            return 0.0
        nominal = model.nominal
        candidates = nominal.angle[:-1]
        template = nominal.current - nominal.current.mean()
        seen = current - current.mean()
        scores = [
            float(np.interp(np.mod(angle + phase, 2.0 * np.pi), nominal.angle, template) @ seen) for phase in candidates
        ]
        return float(candidates[int(np.argmax(scores))])


def data_of(measurement: Measurement, start: float | None = None, stop: float | None = None) -> Data:
    """Cut out what is fitted: from ``start`` [s], or where the motor is switched on if that is later, to ``stop`` [s].

    The current is the instantaneous one if there is one, since the average is delayed. A torque counts only if it is
    not computed from the current, as that of the supplier's workbooks is. The default length is 7 s.

    Raises InputError if there is no current or voltage, or too little in the window.
    """
    source = measurement.meta["source"]
    for column in ("current", "voltage"):
        if not measurement.has(column):
            raise InputError(f"{source}: the {column} was not measured; current and voltage are needed to fit")
    time = measurement.values("time")
    instantaneous = measurement.has("current_instantaneous")
    current = _filled(time, measurement, "current_instantaneous" if instantaneous else "current")
    on = int(np.argmax(current >= _INRUSH * current.max()))
    from_rest = on > 0 and (start is None or start <= time[on])
    begin = float(time[on]) if start is None or from_rest else start
    end = begin + _LENGTH if stop is None else stop
    inside = (time >= begin - 1e-9) & (time <= end + 1e-9)
    if np.count_nonzero(inside) < _FEWEST:
        raise InputError(
            f"{source}: {np.count_nonzero(inside)} samples from {begin:g} s to {end:g} s; {_FEWEST} are needed "
            f"(the measurement goes from {time[0]:g} s to {time[-1]:g} s, the motor is on from {time[on]:g} s)"
        )
    torque: Array | None = None
    notes: tuple[str, ...] = ()
    if measurement.has("torque"):
        if _computed(measurement):
            notes = (f"{Path(source).name}: the torque is computed from the current and tells nothing of its own",)
        else:
            torque = _filled(time, measurement, "torque")[inside]
    return Data(
        name=measurement.name,
        time=time[inside],
        supply=_filled(time, measurement, "voltage")[inside],
        current=current[inside],
        torque=torque,
        noise=(_noise(current[inside]), _noise(torque) if torque is not None else 1.0),
        from_rest=from_rest,
        source=source,
        synthetic=measurement.meta["synthetic"],
        notes=notes,
    )


def distinct(data: Sequence[Data]) -> list[Data]:
    """Give those of the same name the names of their files too, or else numbers."""
    names = [each.name for each in data]
    files = [f"{each.name}, {Path(each.source).name}" for each in data]
    found = []
    for number, (each, name, file) in enumerate(zip(data, names, files, strict=True), 1):
        if names.count(name) > 1:
            found.append(replace(each, name=file if files.count(file) == 1 else f"{file} [{number}]"))
        else:
            found.append(each)
    return found


def _filled(time: Array, measurement: Measurement, column: str) -> Array:
    """A column with its gaps interpolated; reading has warned of them."""
    values = measurement.values(column)
    gaps = np.isnan(values)
    return np.interp(time, time[~gaps], values[~gaps])


def _computed(measurement: Measurement) -> bool:
    """Whether the torque is a linear function of the current, as in the supplier's files."""
    if measurement.meta["torque_line"] is not None:
        return True
    torque = measurement.values("torque")
    for column in ("current", "current_instantaneous"):
        if measurement.has(column):
            current = measurement.values(column)
            good = ~(np.isnan(torque) | np.isnan(current))
            line = np.polynomial.Polynomial.fit(current[good], torque[good], 1)
            if np.std(torque[good] - line(current[good])) <= _AFFINE * np.std(torque[good]):
                return True
    return False


def _noise(values: Array) -> float:
    """Standard deviation of white noise on a smooth signal: of second differences, robustly, over sqrt(6)."""
    second = np.diff(values, 2)
    deviation = 1.4826 * float(np.median(np.abs(second - np.median(second)))) / np.sqrt(6.0)
    return float(max(deviation, 1e-6 * float(np.ptp(values)), 1e-12))

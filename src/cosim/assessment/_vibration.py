"""Vibration measures of a run: torque, current, their rates, acceleration, shocks, spectrum, power."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cosim.assessment._method import Method
from cosim.assessment._sampled import band_rms, lines, mean, mean_rate, rms
from cosim.assessment._trace import Array, Trace, trace
from cosim.assessment._turning import revolution_time, starting_time, turning_points
from cosim.engine import Result
from cosim.errors import InputError

if TYPE_CHECKING:
    import pandas as pd


MEASURED = ("tau_crank", "i_motor", "v_motor", "w_motor", "w_crank", "w_ds", "w_ps", "phi_crank", "park")
"""Signals that are looked at in a run."""


@dataclass(frozen=True)
class Measure:
    """A number about a run: what it is, in which unit."""

    label: str
    value: float
    unit: str


@dataclass(frozen=True)
class Vibration:
    """The measures of a run by key, and the strongest lines (frequency [Hz], amplitude) of torque and current."""

    name: str
    method: Method
    measures: Mapping[str, Measure]
    lines: Mapping[str, tuple[tuple[float, float], ...]]
    notes: tuple[str, ...] = ()

    def __getitem__(self, key: str) -> float:
        """Return the value of a measure."""
        return self.measures[key].value

    def to_dict(self) -> dict[str, object]:
        """Return everything as plain texts, lists and numbers, for JSON."""
        method = {key: "inf" if value == math.inf else value for key, value in asdict(self.method).items()}
        return {
            "name": self.name,
            "method": method | {"bands": list(self.method.bands)},
            "measures": {key: asdict(measure) for key, measure in self.measures.items()},
            "lines": {key: [list(line) for line in found] for key, found in self.lines.items()},
            "notes": list(self.notes),
        }


@dataclass(frozen=True)
class Signal:
    """What is looked at as a signal of its own: x(t) from ``time`` on, called ``key`` in keys of measures."""

    key: str
    label: str
    unit: str
    time: Array
    values: Array


def vibration(source: Trace | Result | pd.DataFrame | Path | str, method: Method | None = None) -> Vibration:
    """Measure the vibration of a run.

    Of x(t) over the length T of the run: peak max |x|, RMS sqrt(1/T int x^2 dt), peak to peak max x - min x, for

    * crank torque ``tau_crank`` [N.m] and motor current ``i_motor`` [A];
    * their rates [N.m/s, A/s]: the mean of the derivative over a window, (x(t) - x(t - w)) / w, which is exact;
    * motor acceleration: the same of ``w_motor`` [rad/s2]; and of the crank's pin, radius times that of ``w_crank``
      [m/s2], beside which figure 1.1 of the source can be put: shape and order, since that was measured on a housing.

    Deviation of the current from its RMS I (section 3.5): sqrt(1/T int (i - I)^2 dt), the same over I, and max |i - I|.
    Shocks: peak to peak of torque, largest rates and acceleration in the time of the start, and around the turning
    points, the worst of them and the mean. Spectrum: RMS in bands and the strongest lines, under a Hann window. Power:
    ``v_motor`` times ``i_motor`` [W], its integral, and the work of the crank.

    What has no column is left out, and told in the notes.

    Args:
        source: the run, with some of the columns that are named.
        method: lengths of windows, bands.

    Raises:
        InputError: there is none of the columns, or the rows are too far apart for the window.
    """
    method = method or Method()
    run = _Run(trace(source), method)
    measures = dict(run.all())
    if not measures:
        raise InputError(
            f"{run.trace.name}: none of the columns tau_crank, i_motor, w_motor and w_crank is there, nothing can be "
            "measured; a column with another name is given by --column tau_crank=NAME"
        )
    return Vibration(run.trace.name, method, measures, run.lines(), tuple(run.notes))


class _Run:
    """The rows of a run within the span, and what is measured of them."""

    def __init__(self, trace: Trace, method: Method) -> None:
        self.trace, self.method = trace, method
        inside = (trace.time >= method.since) & (trace.time <= method.until)
        if inside.sum() < 2:
            upto = f" up to {method.until:g} s" if method.until < np.inf else ""
            raise InputError(
                f"{trace.name}: no two rows from {method.since:g} s on{upto}; "
                f"the run has rows from {trace.time[0]:g} s to {trace.time[-1]:g} s"
            )
        self.inside = inside
        self.time = trace.time[inside]
        self.notes = [] if trace.complete else ["the run ended early: its result is marked incomplete"]
        step = float(np.diff(self.time).max())
        shortest = min(method.window, 0.5 / method.bands[-1])
        if step > shortest * (1 + 1e-9):
            raise InputError(
                f"{trace.name}: rows are up to {step:.3g} s apart; windows of {method.window:g} s and frequencies "
                f"up to {method.bands[-1]:g} Hz need at most {shortest:.3g} s: run it with --set output_interval=1ms"
            )
        if self.time[-1] - self.time[0] < 2 * method.window:
            raise InputError(f"{trace.name}: {self.time[-1] - self.time[0]:g} s are too short to measure anything")
        missing = [name for name in ("tau_crank", "i_motor", "v_motor", "w_motor", "w_crank") if not trace.has(name)]
        if missing:
            self.notes.append(f"not measured for want of a column: what needs {', '.join(missing)}")

    def signal(self, name: str, unit: str) -> Array | None:
        """Return the rows of a column, None if there is none."""
        return self.trace.signal(name, unit)[self.inside] if self.trace.has(name) else None

    def all(self) -> Iterator[tuple[str, Measure]]:
        """Yield the measures in the order in which they are shown."""
        yield from self._wiping()
        plain, rates = list(self._plain()), list(self._rates())
        for signal in [*plain, *rates]:
            yield from _extent(signal)
        yield from self._deviation()
        yield from self._start(plain, rates)
        yield from self._turns(plain, rates)
        yield from self._bands(plain)
        yield from self._power()

    def lines(self) -> dict[str, tuple[tuple[float, float], ...]]:
        """Return the strongest lines of torque and current."""
        count, high = self.method.lines, self.method.bands[-1]
        return {s.key: tuple(lines(s.time, s.values, count, high)) for s in self._plain()}

    def _plain(self) -> Iterator[Signal]:
        for key, label, name, unit in (
            ("torque", "crank torque", "tau_crank", "N.m"),
            ("current", "motor current", "i_motor", "A"),
        ):
            values = self.signal(name, unit)
            if values is not None:
                yield Signal(key, label, unit, self.time, values)

    def _rates(self) -> Iterator[Signal]:
        for key, label, name, unit, rated, factor in (
            ("torque_rate", "rate of the crank torque", "tau_crank", "N.m", "N.m/s", 1.0),
            ("current_rate", "rate of the motor current", "i_motor", "A", "A/s", 1.0),
            ("motor_acceleration", "acceleration of the motor", "w_motor", "rad/s", "rad/s2", 1.0),
            ("pin_acceleration", "acceleration of the crank pin", "w_crank", "rad/s", "m/s2", self.method.radius),
        ):
            values = self.signal(name, unit)
            if values is not None:
                time, rate = mean_rate(self.time, values, self.method.window)
                yield Signal(key, label, rated, time, factor * rate)

    def _wiping(self) -> Iterator[tuple[str, Measure]]:
        length = revolution_time(self.trace, self.inside)
        if length is not None:
            yield "revolution_time", Measure("time of a revolution", length, "s")

    def _deviation(self) -> Iterator[tuple[str, Measure]]:
        current = self.signal("i_motor", "A")
        if current is None:
            return
        effective = rms(self.time, current)
        deviation = rms(self.time, current - effective)
        yield "current_deviation", Measure("deviation of the current from its RMS", deviation, "A")
        if effective > 0:
            yield "current_deviation_relative", Measure("the same over the RMS", deviation / effective, "1")
        largest = float(np.abs(current - effective).max())
        yield "current_deviation_peak", Measure("largest deviation from the RMS", largest, "A")

    def _start(self, plain: list[Signal], rates: list[Signal]) -> Iterator[tuple[str, Measure]]:
        begin = starting_time(self.trace, self.inside)
        if begin is None:
            self.notes.append("no start: the motor turns already when what is looked at begins, or no current flows")
            return
        for shock in _shocks(plain, rates, begin, begin + self.method.start, self.method.window):
            yield f"start_{shock[0]}", Measure(f"start: {shock[1]}", shock[2], shock[3])

    def _turns(self, plain: list[Signal], rates: list[Signal]) -> Iterator[tuple[str, Measure]]:
        reach = self.method.around
        begin = starting_time(self.trace, self.inside)
        earliest = self.time[0] if begin is None else begin + self.method.start
        turns, rockers = turning_points(self.trace, self.inside)
        turns = [t for t in turns if t - reach >= earliest and t + reach <= self.time[-1]]
        if not turns:
            self.notes.append("no turning point: neither rockers turn, nor does the crank pass half a turn")
            return
        if not rockers:
            self.notes.append("turning points are taken at half turns of the crank, since there are no rockers")
        yield "turns", Measure("turning points", float(len(turns)), "1")
        found = [list(_shocks(plain, rates, t - reach, t + reach, self.method.window)) for t in turns]
        for key, label, _, unit in found[0]:
            values = [value for shocks in found for other, _, value, _ in shocks if other == key]
            yield f"turn_{key}_worst", Measure(f"turning points, the worst: {label}", max(values), unit)
            yield f"turn_{key}_mean", Measure(f"turning points, on average: {label}", float(np.mean(values)), unit)

    def _bands(self, plain: list[Signal]) -> Iterator[tuple[str, Measure]]:
        for signal in plain:
            for low, high in zip(self.method.bands, self.method.bands[1:], strict=False):
                value = band_rms(signal.time, signal.values, low, high)
                label = f"{signal.label}, RMS from {low:g} to {high:g} Hz"
                yield f"{signal.key}_band_{low:g}_{high:g}", Measure(label, value, signal.unit)

    def _power(self) -> Iterator[tuple[str, Measure]]:
        length = float(self.time[-1] - self.time[0])
        pairs = (
            ("power", "electrical power", "v_motor", "V", "i_motor", "A"),
            ("crank_power", "power of the crank", "tau_crank", "N.m", "w_crank", "rad/s"),
        )
        for key, label, *names in pairs:
            a, b = self.signal(names[0], names[1]), self.signal(names[2], names[3])
            if a is None or b is None:
                continue
            power = a * b
            yield f"{key}_mean", Measure(f"{label}, mean", mean(self.time, power), "W")
            yield f"{key}_peak", Measure(f"{label}, peak", float(np.abs(power).max()), "W")
            yield f"{key}_energy", Measure(f"{label}, energy", mean(self.time, power) * length, "J")


def _extent(signal: Signal) -> Iterator[tuple[str, Measure]]:
    values, unit = signal.values, signal.unit
    yield f"{signal.key}_peak", Measure(f"{signal.label}, peak", float(np.abs(values).max()), unit)
    yield f"{signal.key}_rms", Measure(f"{signal.label}, RMS", rms(signal.time, values), unit)
    yield f"{signal.key}_peak_to_peak", Measure(f"{signal.label}, peak to peak", float(np.ptp(values)), unit)


def _shocks(
    plain: list[Signal], rates: list[Signal], begin: float, end: float, window: float
) -> Iterator[tuple[str, str, float, str]]:
    """Yield key, label, value and unit of what happens between two times [s]: steps of torque, largest rates."""
    for signal in plain:
        values = signal.values[(signal.time >= begin - 1e-9) & (signal.time <= end + 1e-9)]
        yield f"{signal.key}_peak_to_peak", f"{signal.label}, peak to peak", float(np.ptp(values)), signal.unit
    for signal in rates:
        values = signal.values[(signal.time >= begin + window - 1e-9) & (signal.time <= end + 1e-9)]
        yield f"{signal.key}", f"{signal.label}, peak", float(np.abs(values).max()), signal.unit

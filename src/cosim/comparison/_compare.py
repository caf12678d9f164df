"""Compares the torque, current or speed of a run with that of a measurement."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cosim.assessment import Trace, trace
from cosim.comparison import _measures as measures
from cosim.comparison._alignment import POINTS, find_lag, over_angle
from cosim.comparison._curve import Curve, Pair, on_one_grid
from cosim.comparison._options import SIGNALS, Options, Quantity
from cosim.comparison._revolutions import Envelope, envelope, share_inside, turned
from cosim.comparison._tube import Tube, tube
from cosim.engine import Result
from cosim.errors import InputError
from cosim.measurement import Measurement, smooth
from cosim.measurement._processing import AVERAGE
from cosim.measurement._supplier import SAMPLE_TIME

Array = NDArray[np.float64]

_HIGHEST = 20.0
"""Frequencies [Hz] up to which the spectra are reported."""
_APART = 0.25
"""Revolutions by which the cranks may drift apart before that is told."""
_WORTH_A_NOTE = 0.01
"""An offset of the torque by this part of its range is told."""


_FIGURES = (
    "rmse_{}",
    "nrmse",
    "bias_{}",
    "peak_error_{}",
    "valley_error_{}",
    "correlation",
    "gain",
    "offset_{}",
    "lag_s",
    "peak_timing_mean_s",
    "peak_timing_worst_s",
    "tube_excess_{}",
    "tube_outside",
    "coherence_mean",
)


def figure_names(quantity: Quantity) -> tuple[str, ...]:
    """Return the names of the figures of a comparison; those with a unit end in it."""
    return tuple(name.format(SIGNALS[quantity][2]) for name in _FIGURES)


@dataclass(frozen=True)
class Revolutions:
    """Both over the crank angle; the measurement's is turned back by ``shift`` of the points of a revolution."""

    result: Envelope
    measured: Envelope
    shift: int


@dataclass(frozen=True)
class Comparison:
    """A result and a measurement on one grid, and how well they agree.

    ``pair`` has both at the same instants of the result's time, in ``unit`` (in revolutions of the crank instead of
    seconds if aligned by "angle"); ``lag`` [s] is by how much the measurement was later. ``tube`` lies around the
    measurement, ``outside`` of shape (n,) tells by how much the result leaves it. ``timing`` [s] is how much later each
    peak of the result is than the measurement's. ``spectrum`` goes up to 20 Hz.
    """

    result: str
    measurement: str
    options: Options
    unit: str
    suffix: str
    pair: Pair
    lag: float
    tube: Tube
    outside: Array
    timing: Array
    spectrum: measures.Spectrum
    revolutions: Revolutions | None
    notes: tuple[str, ...]
    synthetic: bool

    @property
    def tube_pass(self) -> bool:
        """Whether the result stays inside the tube."""
        return not bool(self.outside.any())

    def figures(self) -> dict[str, float]:
        """Return the figures by name; those with a unit end in it."""
        line = measures.line(self.pair)
        values = (
            measures.rmse(self.pair),
            measures.nrmse(self.pair),
            measures.bias(self.pair),
            measures.peak_error(self.pair),
            measures.valley_error(self.pair),
            measures.correlation(self.pair),
            line.gain,
            line.offset,
            self.lag,
            float(np.mean(self.timing)) if len(self.timing) else math.nan,
            float(self.timing[np.abs(self.timing).argmax()]) if len(self.timing) else math.nan,
            float(self.outside.max()),
            float(np.mean(self.outside > 0.0)),
            self.spectrum.mean_coherence(),
        )
        return dict(zip(figure_names(self.options.quantity), values, strict=True))

    def to_dict(self) -> dict[str, object]:
        """Return everything as a JSON document; what is not a number becomes None."""
        figures = {name: value if math.isfinite(value) else None for name, value in self.figures().items()}
        turns = self.revolutions
        return {
            "result": self.result,
            "measurement": self.measurement,
            "synthetic": self.synthetic,
            "quantity": self.options.quantity,
            "unit": self.unit,
            "align": self.options.align,
            "smoothing": self.options.smoothing,
            "options": {
                name: None if isinstance(value, float) and not math.isfinite(value) else value
                for name, value in asdict(self.options).items()
            },
            **figures,
            "tube_pass": self.tube_pass,
            "samples": len(self.pair.time),
            "step_s": self.pair.step,
            "peaks": len(self.timing),
            "envelope_inside": share_inside(turns.result, turns.measured, turns.shift) if turns else None,
            "revolutions": [turns.result.revolutions, turns.measured.revolutions] if turns else None,
            "spectrum": {
                "frequency_hz": self.spectrum.frequency.tolist(),
                "result": self.spectrum.result.tolist(),
                "measured": self.spectrum.measured.tolist(),
                "coherence": [v if math.isfinite(v) else None for v in self.spectrum.coherence.tolist()],
            },
            "notes": list(self.notes),
        }


def compare(
    result: Trace | Result | Path | str,
    measurement: Measurement,
    options: Options | None = None,
    *,
    aliases: Mapping[str, str] | None = None,
) -> Comparison:
    """Lay a measurement over a result and measure the difference, result minus measurement.

    Args:
        result: what ``cosim run`` wrote or ``simulate`` returned.
        measurement: what ``cosim.measurement.read`` returned.
        options: quantity, alignment, smoothing and tube.
        aliases: the result's column for a signal, if it is called otherwise than usual.

    Raises:
        InputError: a signal is missing, they have no time in common, or cannot be aligned.
    """
    options = options or Options()
    run = trace(result, aliases=aliases)
    signal, unit, suffix = SIGNALS[options.quantity]
    simulated, notes = _of_run(run, signal, unit), list[str]()
    measured = _of_measurement(measurement, options, notes)
    part = simulated.between(options.start, options.stop)
    if options.align == "angle":
        measured = measured.between(options.start, options.stop)
        turns = _revolutions(part, measured, notes)
        pair, lag = _over_angle(part, measured)
        period = _period(measured)
        half_width = options.tube_x / _period(part)
        lag *= period
    else:
        period = 1.0
        lag = find_lag(part, measured, options.align, options.lag_most)
        if options.align == "correlation" and abs(abs(lag) - options.lag_most) < 2 * max(part.step, measured.step):
            notes.append(
                f"the best lag is at the end of those looked at, {lag:g} s; set lag_most higher, or align=onset"
            )
        aligned = measured.later(-lag)
        pair, half_width = on_one_grid(part, aligned), options.tube_x
        # the revolutions of what is compared, not those of a longer measurement's start-up
        first, last = pair.time[0], pair.time[-1]
        both = part.between(first, last), aligned.between(first, last)
        turns = _revolutions(*both, notes)
        notes += _drift(*both)
    if options.smoothing != "none":
        length = max(3, round(AVERAGE * SAMPLE_TIME / (pair.step * period)))
        pair = Pair(pair.time, *(smooth(values, options.smoothing, length) for values in (pair.result, pair.measured)))
    height = max(options.tube_y, options.tube_y_relative * float(np.ptp(pair.measured)))
    around = tube(pair.time, pair.measured, half_width, height)
    timed = Pair(pair.time * period, pair.result, pair.measured)
    return Comparison(
        result=run.name,
        measurement=measurement.name,
        options=options,
        unit=unit,
        suffix=suffix,
        pair=pair,
        lag=lag,
        tube=around,
        outside=around.outside(pair.time, pair.result),
        timing=measures.peak_timing(timed),
        spectrum=measures.spectrum(timed, _HIGHEST),
        revolutions=turns,
        notes=tuple(notes),
        synthetic=measurement.meta["synthetic"],
    )


def _of_run(run: Trace, signal: str, unit: str) -> Curve:
    angle = run.signal("phi_crank", "rad") if run.has("phi_crank") else None
    return Curve(run.name, run.time, run.signal(signal, unit), angle)


def _of_measurement(measurement: Measurement, options: Options, notes: list[str]) -> Curve:
    quantity = options.quantity
    if not measurement.has(quantity):
        there = [name for name in measurement.frame.columns if name != "time" and measurement.has(name)]
        raise InputError(f"{measurement.meta['source']}: the {quantity} was not measured; there is {', '.join(there)}")
    time = measurement.values("time")
    values = measurement.speed() if quantity == "speed" else measurement.values(quantity)
    gaps = np.isnan(values)
    if gaps.any():
        notes.append(f"{int(gaps.sum())} samples of the measurement are no numbers; interpolated")
        values = np.interp(time, time[~gaps], values[~gaps])
    if quantity == "torque":
        values = values + _torque_zero(measurement, options, float(np.ptp(values)), notes)
    return Curve(measurement.name, time, values, _angle(measurement))


def _torque_zero(measurement: Measurement, options: Options, spread: float, notes: list[str]) -> float:
    """Return what is to be added to the torque [N.m], which the source makes zero at the onset.

    Raises `InputError` if it is unknown.
    """
    there = measurement.meta["torque_at_onset"]
    if options.torque_zero == "line":
        if math.isnan(there):
            raise InputError(
                f"{measurement.meta['source']}: there is no line of current over torque; set torque_zero=onset"
            )
        return there
    if abs(there) > _WORTH_A_NOTE * spread:
        notes.append(
            f"the torque has been made zero at the onset, as the source does it; by the workbook's line it is "
            f"{there:.4g} N.m there, which torque_zero=line takes into account"
        )
    return 0.0


def _angle(measurement: Measurement) -> Array | None:
    """Return the crank angle as the integral of the speed, None if that was not measured."""
    if not measurement.has("speed"):
        return None
    time, speed = measurement.values("time"), measurement.speed()
    good = ~np.isnan(speed)
    speed = np.interp(time, time[good], speed[good])
    return np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))))


def _revolutions(result: Curve, measured: Curve, notes: list[str]) -> Revolutions | None:
    try:
        a, b = (envelope(over_angle(curve)) for curve in (result, measured))
    except InputError as error:
        notes.append(f"no comparison over the revolution: {error}")
        return None
    return Revolutions(a, b, turned(a, b))


def _drift(result: Curve, measured: Curve) -> list[str]:
    """Tell of cranks that run at different speeds, so that no lag can lay one over the other."""
    if result.angle is None or measured.angle is None:
        return []
    turns = [float(angle[-1] - angle[0]) / (2.0 * np.pi) for angle in (result.angle, measured.angle)]
    if abs(turns[0] - turns[1]) < _APART:
        return []
    return [
        f"the crank makes {turns[0]:.4g} revolutions in the result, {turns[1]:.4g} in the measurement meanwhile, so "
        "that the two drift apart; align=angle compares them over the crank angle"
    ]


def _over_angle(result: Curve, measured: Curve) -> tuple[Pair, float]:
    """Return both over the angle, and by how many revolutions the measurement was turned back."""
    a, b = over_angle(result), over_angle(measured)
    shift = turned(envelope(a), envelope(b)) / POINTS
    return on_one_grid(a, replace(b, time=b.time - shift)), shift


def _period(curve: Curve) -> float:
    """The mean duration [s] of a revolution."""
    if curve.angle is None:
        raise InputError(
            f"{curve.name}: the crank angle is unknown; it follows from a column phi_crank or from the speed"
        )
    return float(2.0 * np.pi * (curve.time[-1] - curve.time[0]) / (curve.angle[-1] - curve.angle[0]))

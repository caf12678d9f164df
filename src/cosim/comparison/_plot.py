"""Pictures of a comparison."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cosim.colours import BLACK, BLUE, RED
from cosim.comparison._alignment import POINTS
from cosim.comparison._compare import Comparison, Revolutions
from cosim.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_RESULT, _MEASURED, _OUTSIDE = BLUE, BLACK, RED
_DPI = 110


def draw(comparison: Comparison, path: Path) -> None:
    """Draw both signals with the tube, the residual, and a revolution if the crank angle is known, as a PNG file.

    Raises `InputError` if the file cannot be written.
    """
    with warnings.catch_warnings():
        # matplotlib's own: nothing that the user of a picture could do something about
        warnings.simplefilter("ignore")
        import matplotlib as mpl

        mpl.use("Agg")
        from matplotlib.figure import Figure

        turns = comparison.revolutions
        figure = Figure(figsize=(11, 9.5 if turns else 6.5), layout="constrained")
        heights = [2.2, 1.2, 2.0] if turns else [2.2, 1.2]
        axes = figure.subplots(len(heights), 1, gridspec_kw={"height_ratios": heights})
        _overlay(axes[0], comparison)
        _residual(axes[1], comparison)
        axes[1].sharex(axes[0])
        if turns:
            _revolution(axes[2], comparison, turns)
        figure.align_ylabels()
        try:
            figure.savefig(path, dpi=_DPI)
        except OSError as error:
            raise InputError(f"cannot be written: {error.strerror or error}", file=path) from error


def _label(comparison: Comparison) -> str:
    return f"{comparison.options.quantity} [{comparison.unit}]"


def _overlay(axes: Axes, comparison: Comparison) -> None:
    pair, tube = comparison.pair, comparison.tube
    figures = comparison.figures()
    axes.fill_between(tube.time, tube.lower, tube.upper, color="0.85", linewidth=0, label="tube around the measurement")
    axes.plot(pair.time, pair.measured, color=_MEASURED, linewidth=1.0, label=f"measured: {comparison.measurement}")
    axes.plot(pair.time, pair.result, color=_RESULT, linewidth=1.2, label=f"simulated: {comparison.result}")
    verdict = "inside the tube" if comparison.tube_pass else f"outside the tube for {figures['tube_outside']:.1%}"
    axes.figure.suptitle(
        f"RMSE {figures[f'rmse_{comparison.suffix}']:.3g} {comparison.unit} ({figures['nrmse']:.1%} of the range), "
        f"bias {figures[f'bias_{comparison.suffix}']:.3g} {comparison.unit}, correlation "
        f"{figures['correlation']:.4f}, lag {comparison.lag:.4g} s; {verdict}",
        fontsize=10,
    )
    axes.set_ylabel(_label(comparison))
    axes.margins(x=0)
    axes.grid(alpha=0.3)
    _legend_above(axes)


def _residual(axes: Axes, comparison: Comparison) -> None:
    pair = comparison.pair
    out = comparison.outside > 0.0
    axes.axhline(0.0, color="0.5", linewidth=0.8)
    axes.plot(pair.time, pair.residual, color=_RESULT, linewidth=0.9)
    if out.any():
        axes.plot(pair.time[out], pair.residual[out], ".", color=_OUTSIDE, markersize=3, label="outside the tube")
        _legend_above(axes)
    axes.set_ylabel(f"simulated - measured\n[{comparison.unit}]")
    axes.set_xlabel("revolutions of the crank" if comparison.options.align == "angle" else "time [s]")
    axes.margins(x=0)
    axes.grid(alpha=0.3)


def _revolution(axes: Axes, comparison: Comparison, turns: Revolutions) -> None:
    degrees = np.arange(POINTS) * 360.0 / POINTS
    parts = (
        (turns.measured, turns.shift, _MEASURED, "measured"),
        (turns.result, 0, _RESULT, "simulated"),
    )
    for envelope, shift, colour, name in parts:
        low, mean, high = (np.roll(values, -shift) for values in (envelope.low, envelope.mean, envelope.high))
        axes.fill_between(degrees, low, high, color=colour, alpha=0.15, linewidth=0)
        axes.plot(
            degrees, mean, color=colour, linewidth=1.2, label=f"{name}: mean of {envelope.revolutions} revolutions"
        )
    axes.set_xlim(0.0, 360.0)
    axes.set_xticks(range(0, 361, 45))
    axes.set_xlabel(
        "crank angle from the first instant on [deg]; bands from the least to the largest of all revolutions"
    )
    axes.set_ylabel(_label(comparison))
    axes.grid(alpha=0.3)
    _legend_above(axes)


def _legend_above(axes: Axes) -> None:
    """Where it hides no line."""
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, frameon=False, fontsize=9, borderaxespad=0.2)

"""Pictures of a fit."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cosim.calibration._results import Agreement, Fit
from cosim.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from cosim.calibration._data import Data

Array = NDArray[np.float64]

# Okabe and Ito's colours, which stay apart for colour-blind readers.
_MODELLED, _MEASURED = "#0072B2", "#000000"
_DPI = 110


def draw_fit(found: Fit, path: Path) -> None:
    """Draw for each measurement the measured and the modelled current and their difference, as a PNG file.

    Raises `InputError` if the file cannot be written.
    """
    with warnings.catch_warnings():
        # matplotlib's own: nothing that the user of a picture could do something about
        warnings.simplefilter("ignore")
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        count = len(found.data)
        figure = Figure(figsize=(11, 1.0 + 3.6 * count), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.subplots(2 * count, 1, squeeze=False, gridspec_kw={"height_ratios": [2.2, 1.0] * count})[:, 0]
        for k, (data, modelled, agreement) in enumerate(zip(found.data, found.modelled, found.agreements, strict=True)):
            _draw(axes[2 * k], axes[2 * k + 1], data, modelled[0], agreement)
        axes[-1].set_xlabel("time [s]")
        _title(figure, found)
        figure.align_ylabels()
        try:
            figure.savefig(path, dpi=_DPI)
        except OSError as error:
            raise InputError(f"cannot be written: {error.strerror or error}", file=path) from error


def _title(figure: Figure, found: Fit) -> None:
    lines = ["  ".join(f"{e.name} {e.value:.4g} ± {e.error:.2g} {e.unit}" for e in found.estimates if e.of is None)]
    if found.synthetic:
        lines.append("SYNTHETIC DATA: computed, not measured")
    if not found.solved:
        lines.append(f"NOT CONVERGED: {found.limit}")
    figure.suptitle("\n".join(line for line in lines if line), fontsize=10)


def _draw(upper: Axes, lower: Axes, data: Data, modelled: Array, agreement: Agreement) -> None:
    upper.plot(data.time, data.current, ".", color=_MEASURED, markersize=1.5, alpha=0.35, label="measured")
    upper.plot(data.time, modelled, color=_MODELLED, linewidth=1.0, label="modelled")
    kind = "held out" if agreement.held_out else "fitted"
    upper.set_title(
        f"{data.name}, {kind}: RMSE {agreement.current_rmse:.3g} A, noise {agreement.noise:.3g} A",
        loc="left", fontsize=10,
    )  # fmt: skip
    upper.legend(loc="upper right", ncols=2, fontsize=9, markerscale=5)
    upper.set_ylabel("current [A]")
    lower.axhline(0.0, color="0.5", linewidth=0.8)
    lower.plot(data.time, modelled - data.current, color=_MODELLED, linewidth=0.5)
    lower.set_ylabel("modelled -\nmeasured [A]")
    lower.sharex(upper)
    for axes in (upper, lower):
        axes.margins(x=0)
        axes.grid(alpha=0.3)

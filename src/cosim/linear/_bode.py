"""Bode pictures, by python-control and matplotlib, which are imported only here."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cosim.colours import BLACK, BLUE, GREEN, ORANGE, PINK, RED, SKY
from cosim.errors import InputError
from cosim.linear._system import LinearSystem

_LINES = (
    (BLUE, "-"), (RED, "--"), (GREEN, "-."), (PINK, ":"), (ORANGE, "-"), (SKY, "--"),
    (BLACK, "-."),
)  # fmt: skip
"""Colours, and line styles for those who print in grey."""
_MOST_INPUTS = 4
_POINTS = 600
_ROUNDING = 1e-12
_DPI = 110


def bode(system: LinearSystem, path: Path) -> list[str]:
    """Draw amplitude and phase of every output for every input over the angular frequency, and save a PNG.

    Amplitudes are in dB of the output's unit over the input's. At most four inputs and seven outputs for each are
    drawn; an output that an input does not reach has no line.

    Returns:
        What was left out, as notes for the user.

    Raises:
        InputError: python-control is not installed, or the system has no input, no output, or no way between them.
    """
    import matplotlib as mpl

    linear = system.control()
    if not system.inputs or not system.outputs:
        missing = "input" if not system.inputs else "output"
        raise InputError(
            f"{system.model} has no Real {missing}, so there is no Bode picture; name outputs with --output"
        )
    omega = _frequencies(system)
    response = linear(1j * omega, squeeze=False, warn_infinite=False)
    reaches = _reaches(system, response)
    moving = np.flatnonzero(reaches.any(axis=0))
    columns = moving[:_MOST_INPUTS]
    rows = np.flatnonzero(reaches[:, columns].any(axis=1))
    if not len(columns):
        raise InputError(f"{system.model}: no input reaches an output, so there is no Bode picture")
    with mpl.rc_context({"text.parse_math": False}):
        _draw(system, omega, response, reaches, rows[: len(_LINES)], columns, path)
    return [
        f"the Bode picture has room for {most} {kind}s; left out: {', '.join(signals[k].name for k in found[most:])}"
        for kind, signals, found, most in (
            ("input", system.inputs, moving, _MOST_INPUTS),
            ("output", system.outputs, rows, len(_LINES)),
        )
        if len(found) > most
    ]


def _frequencies(system: LinearSystem) -> NDArray[np.float64]:
    """Two decades beyond the slowest and the fastest pole [rad/s]; poles at zero aside."""
    sizes = [pole.frequency for pole in system.poles]
    sizes = [size for size in sizes if size > 1e-9 * max(sizes)] or [1.0]
    return np.logspace(np.floor(np.log10(min(sizes))) - 1, np.ceil(np.log10(max(sizes))) + 1, _POINTS)


def _reaches(system: LinearSystem, response: NDArray[np.complex128]) -> NDArray[np.bool_]:
    """Which outputs each input moves by more than rounding errors do; shape (outputs, inputs)."""
    sizes = np.where(np.isfinite(response), np.abs(response), 0.0).max(axis=2)
    sizes = sizes * [max(abs(given.value), 1.0) for given in system.inputs]
    reaches: NDArray[np.bool_] = sizes > _ROUNDING * sizes.max(axis=1, keepdims=True)
    return reaches


def _draw(
    system: LinearSystem,
    omega: NDArray[np.float64],
    response: NDArray[np.complex128],
    reaches: NDArray[np.bool_],
    rows: NDArray[np.intp],
    columns: NDArray[np.intp],
    path: Path,
) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.ticker import FuncFormatter, MultipleLocator, NullFormatter

    figure = Figure(figsize=(1.5 + 5.5 * len(columns), 7.0), dpi=_DPI, layout="constrained")
    canvas = FigureCanvasAgg(figure)
    axes = figure.subplots(2, len(columns), sharex=True, squeeze=False)
    for position, j in enumerate(columns):
        given = system.inputs[j]
        amplitude, phase = axes[:, position]
        for (colour, style), i in zip(_LINES, rows, strict=False):
            if not reaches[i, j]:
                continue
            values = response[i, j]
            label = f"{system.outputs[i].name} [{system.outputs[i].unit}]"
            amplitude.plot(omega, 20 * np.log10(np.abs(values)), color=colour, linestyle=style, label=label)
            phase.plot(omega, np.degrees(_phase(values)), color=colour, linestyle=style)
        amplitude.set_title(f"from {given.name} [{given.unit}]", loc="left", fontsize=10)
        amplitude.legend(fontsize=8, frameon=False)
        phase.yaxis.set_major_locator(MultipleLocator(90))
        phase.set_xlabel("angular frequency [rad/s]")
        for place in (amplitude, phase):
            place.set_xscale("log")
            place.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            place.xaxis.set_minor_formatter(NullFormatter())
            place.grid(alpha=0.25)
            place.spines[["top", "right"]].set_visible(False)
            place.tick_params(labelsize=9)
    axes[0, 0].set_ylabel("amplitude [dB of output unit per input unit]")
    axes[1, 0].set_ylabel("phase [deg]")
    axes[0, 0].set_xlim(omega[0], omega[-1])
    where = "in its steady state" if system.at == "steady" else f"at t = {system.time:g} s"
    figure.suptitle(f"{system.model}, linearized {where}", fontsize=12, fontweight="bold")
    path.parent.mkdir(parents=True, exist_ok=True)
    canvas.print_png(str(path))  # type: ignore[no-untyped-call]


def _phase(values: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Phase without jumps [rad], beginning between -360 and 90 degrees, as Bode pictures do."""
    phase: NDArray[np.float64] = np.unwrap(np.angle(values))
    begun: NDArray[np.float64] = phase - 2 * np.pi * np.ceil((phase[0] - np.pi / 2 - 1e-9) / (2 * np.pi))
    return begun

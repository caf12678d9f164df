"""Pictures of a run: stacked panels over time, chosen by what the variables are called, else by their units."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cosim.colours import BLACK, BLUE, GREEN, ORANGE, PINK, RED, SKY
from cosim.engine import Fault, Result, described
from cosim.errors import InputError
from cosim.units import compatible, linear_map, parse

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FIGURES = ("overview", "detail", "motion", "others")

_COLOURS = (BLUE, RED, GREEN, PINK, SKY, ORANGE, BLACK)
_DETAIL_SECONDS = 4.0
_MOST_LINES = 7
_MOST_PANELS = 16
_MOST_WORDS = 4
_DPI = 110


@dataclass(frozen=True)
class Panel:
    """One pair of axes of a figure: the variables (without component) that belong there, in drawing order.

    ``unit`` is what the axis shows; columns with another unit of the same dimension are converted. ``faint`` ones are
    the background for the others, ``bounds`` the least that the axis spans.
    """

    figure: str
    title: str
    unit: str
    names: tuple[str, ...]
    faint: tuple[str, ...] = ()
    dashed: tuple[str, ...] = ()
    bounds: tuple[float, float] | None = None


# What a wiper drive's variables are called. A system with other names gets one panel for each unit.
PANELS = (
    Panel(
        "overview", "Motor current", "A", ("i_motor", "i_filtered", "i_limit"), faint=("i_motor",), dashed=("i_limit",)
    ),
    Panel("overview", "Duty ratio", "1", ("duty",), bounds=(0.0, 1.0)),
    Panel(
        "overview",
        "Torque at the gear's output shaft",
        "N.m",
        ("tau_crank", "tau_disturbance"),
        dashed=("tau_disturbance",),
    ),
    Panel("overview", "Rocker angle", "deg", ("phi_ds", "phi_ps")),
    Panel("motion", "Rocker angle", "deg", ("phi_ds", "phi_ps")),
    Panel("motion", "Rocker speed", "rad/s", ("w_ds", "w_ps")),
    Panel("motion", "Load torque at the rockers", "N.m", ("tau_ds", "tau_ps")),
    Panel("motion", "Crank speed", "rpm", ("w_crank",)),
    Panel("motion", "Motor speed", "rpm", ("w_motor",)),
)
_STATES, _SWITCHES = "State", "On/off"


@dataclass
class _Axis:
    """A panel with the columns it found: (column name, values in the panel's unit)."""

    panel: Panel
    lines: list[tuple[str, NDArray[np.float64]]] = field(default_factory=list)
    literals: tuple[str, ...] | None = None

    @property
    def height(self) -> float:
        if self.literals:
            return max(1.0, 0.24 * len(self.literals))
        return 0.3 + 0.25 * len(self.lines) if self.panel.title == _SWITCHES else 1.6


def plot(result: Result, folder: Path, title: str = "") -> list[Path]:
    """Draw a result into ``folder``: at most the PNG files `FIGURES`, overview.png first.

    ``overview`` shows the drive or, for a system with other names, everything by unit; ``detail`` its last seconds,
    ``motion`` speeds and angles, ``others`` what has no panel of its own. A figure has at most 16 panels, so that it
    can be looked at; further ones are left out. An input with faults is drawn where its name belongs; behind it the
    time that the faults last is grey. Draws nothing for fewer than two rows.
    """
    if len(result.time) < 2:
        return []
    axes = _panels(result)
    known = any(axis.panel in PANELS for axis in axes)
    axes += _by_unit(result, axes, "others" if known else "overview")
    end = float(result.time[-1])
    heading = title if result.complete else f"{title} (incomplete, stopped at {end:.4g} s)".strip()
    figures = {name: [axis for axis in axes if axis.panel.figure == name][:_MOST_PANELS] for name in FIGURES}
    if end > 2 * _DETAIL_SECONDS:
        figures["detail"] = figures["overview"]
    import matplotlib as mpl  # slow to import, and not needed without plots

    # Titles and names are shown as they are: no formulas between dollar signs, no words about glyphs a font lacks.
    with mpl.rc_context({"text.parse_math": False}), warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return [
            _draw(result, chosen, folder / f"{name}.png", heading, end - _DETAIL_SECONDS if name == "detail" else 0.0)
            for name, chosen in figures.items()
            if chosen
        ]


def _panels(result: Result) -> list[_Axis]:
    """Return the axes of `PANELS` that have a column, and behind the duty ratio states and on/off signals."""
    axes: list[_Axis] = []
    for panel in PANELS:
        axis = _Axis(panel)
        for wanted in panel.names:
            for name in result.columns:
                if name.rpartition(".")[2] == wanted and name not in result.literals:
                    values = _in_unit(result, name, panel.unit)
                    if values is not None:
                        axis.lines.append((name, values))
        if axis.lines:
            axes.append(axis)
    states = [
        _Axis(Panel("overview", _STATES, "", (name,)), [(name, _floats(result, name))], literals)
        for name, literals in result.literals.items()
    ]
    switches = _Axis(Panel("overview", _SWITCHES, "", ()), [(n, _floats(result, n)) for n in _switch_names(result)])
    places = [index for index, axis in enumerate(axes) if axis.panel.figure == "overview"][:2]
    place = places[-1] + 1 if places else 0
    return [*axes[:place], *states, *([switches] if switches.lines else []), *axes[place:]]


def _by_unit(result: Result, shown: list[_Axis], figure: str) -> list[_Axis]:
    """Return one panel for each unit of the columns that are not shown yet, split where there are too many lines."""
    done = {name for axis in shown for name, _ in axis.lines}
    groups: dict[str, list[str]] = {}
    for name in result.columns:
        if name not in done:
            groups.setdefault(result.units.get(name) or "1", []).append(name)
    return [
        _Axis(
            Panel(figure, "", unit, ()), [(name, _floats(result, name)) for name in names[start : start + _MOST_LINES]]
        )
        for unit, names in groups.items()
        for start in range(0, len(names), _MOST_LINES)
    ]


def _switch_names(result: Result) -> list[str]:
    """Return the columns that are Booleans as far as their values tell: integers that are 0 or 1."""
    return [
        name
        for name, values in result.columns.items()
        if values.dtype.kind in "iub" and name not in result.literals and bool(np.isin(values, (0, 1)).all())
    ]


def _floats(result: Result, name: str) -> NDArray[np.float64]:
    return result.columns[name].astype(np.float64)


def _in_unit(result: Result, name: str, unit: str) -> NDArray[np.float64] | None:
    """Return a column in another unit; None if it is of another dimension, and so another quantity of that name."""
    try:
        source, target = parse(result.units.get(name) or "1"), parse(unit)
    except InputError:
        return None
    if not compatible(source, target):
        return None
    factor, offset = linear_map(source, target)
    return _floats(result, name) * factor + offset


def _draw(result: Result, axes: list[_Axis], path: Path, title: str, start: float) -> Path:
    """Draw the axes below each other from ``start`` [s] on, and save the figure."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    heights = [axis.height for axis in axes]
    figure = Figure(figsize=(11, 1.0 + 1.05 * sum(heights)), dpi=_DPI, layout="constrained")
    canvas = FigureCanvasAgg(figure)
    grid = figure.subplots(len(axes), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    since = int(np.searchsorted(result.time, start))
    time = result.time[since:]
    for place, axis in zip(grid, axes, strict=True):
        if axis.literals:
            _draw_states(place, time, axis, since)
        elif axis.panel.title == _SWITCHES:
            _draw_switches(place, time, axis, since)
        else:
            _draw_lines(place, time, axis, since, {".".join(fault.target) for fault in result.faults})
        place.set_title(axis.panel.title, loc="left", fontsize=10)
        _mark_faults(place, result, axis, time)
        place.grid(alpha=0.25)
        place.spines[["top", "right"]].set_visible(False)
        place.tick_params(labelsize=9)
    # The margin keeps a peak at the start, such as an inrush current, off the axis.
    grid[-1].set_xlim(time[0] - 0.005 * (time[-1] - time[0]), time[-1])
    grid[-1].set_xlabel("time [s]" + _words(result.faults, result))
    if title:
        figure.suptitle(title, fontsize=12, fontweight="bold")
    # Unlike savefig, which draws once more to measure, this draws once.
    canvas.print_png(str(path), pil_kwargs={"compress_level": 1})  # type: ignore[no-untyped-call]
    return path


def _mark_faults(place: Axes, result: Result, axis: _Axis, time: NDArray[np.float64]) -> None:
    names = [name for name, _ in axis.lines]
    faults = [fault for fault in result.faults if ".".join(fault.target) in names]
    for start, stop in sorted({(fault.start, min(fault.stop, float(time[-1]))) for fault in faults}):
        if stop > time[0]:
            place.axvspan(max(start, float(time[0])), stop, color="0.5", alpha=0.15, linewidth=0, zorder=0)


def _words(faults: tuple[Fault, ...], result: Result) -> str:
    """Return what was done, a line for each of the first few faults, to stand below a figure."""
    names = [".".join(fault.target) for fault in faults]
    lines = [
        f"fault: {name} {described(fault, result.units.get(name))}"
        for name, fault in zip(names[:_MOST_WORDS], faults, strict=False)
    ]
    more = len(faults) - _MOST_WORDS
    return "".join(f"\n{line}" for line in [*lines, *([f"and {more} more"] if more > 0 else [])])


def _draw_lines(place: Axes, time: NDArray[np.float64], axis: _Axis, since: int, faulty: set[str]) -> None:
    colours = iter(_COLOURS)
    for name, values in axis.lines:
        variable = name.rpartition(".")[2]
        faint = variable in axis.panel.faint and len(axis.lines) > 1 and name not in faulty
        place.plot(
            time,
            _drawable(values[since:]),
            label=name,
            color="#BBBBBB" if faint else next(colours),
            linewidth=3.0 if faint else 1.4,
            linestyle="--" if variable in axis.panel.dashed else "-",
        )
    if axis.panel.bounds is not None:
        place.update_datalim([(time[0], bound) for bound in axis.panel.bounds])
        place.autoscale_view()
    place.set_ylabel(f"[{axis.panel.unit}]")
    place.legend(
        loc="lower right", bbox_to_anchor=(1, 0.98), ncols=_MOST_LINES, fontsize=8, frameon=False, borderaxespad=0
    )


def _drawable(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the values without those, of a run that diverged, whose differences are beyond what axes can span."""
    return np.where(np.abs(values) < 1e300, values, np.nan)


def _draw_states(place: Axes, time: NDArray[np.float64], axis: _Axis, since: int) -> None:
    names = axis.literals or ()
    name, values = axis.lines[0]
    place.plot(time, values[since:], drawstyle="steps-post", color=_COLOURS[0], linewidth=1.4)
    place.set_yticks(range(1, len(names) + 1), names)
    place.set_ylim(0.5, len(names) + 0.5)
    place.set_title(name, loc="right", fontsize=8)


def _draw_switches(place: Axes, time: NDArray[np.float64], axis: _Axis, since: int) -> None:
    """Draw each switch as a band of its own; the outline keeps contacts visible that are shorter than a pixel."""
    for row, (_, values) in enumerate(axis.lines):
        on = values[since:] * 0.8
        place.fill_between(time, row, row + on, step="post", color=_COLOURS[0], linewidth=1.2)
    place.set_yticks([row + 0.4 for row in range(len(axis.lines))], [name for name, _ in axis.lines])
    place.set_ylim(-0.1, len(axis.lines))

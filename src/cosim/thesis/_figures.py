"""The source's figures with its axes, labels and units, so that they can be laid beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cosim.engine import Result
from cosim.thesis._runs import RigRun

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe and Ito's colours, which stay apart for colour-blind readers; the lines differ in style or place besides.
BLUE, RED, GREEN, GREY = "#0072B2", "#D55E00", "#009E73", "#999999"
STATE_COLOURS = {
    "Soft_start": "#009E73",
    "RUN": "#0072B2",
    "turn_point_dec": "#D55E00",
    "turn_point_acc": "#E69F00",
    "Soft_stop": "#CC79A7",
    "IDLE": "#999999",
}
STATE_NAMES = {
    "RUN": "RUN.RUN",
    "turn_point_dec": "RUN.turn_point_dec",
    "turn_point_acc": "RUN.turn_point_acc",
}
"""As the legend of figure 3.12 calls them."""


def system_performance(run: RigRun, path: Path) -> None:
    """Figures 4.9 to 4.18: filtered current on the left, motor voltage and park signal in percent on the right."""
    time = run.result.time
    figure, axes = _figure(f"System performance, {run.load} load")
    right = axes.twinx()
    right.plot(time, 100.0 * run.result.columns["plant.park"], color=GREY, linewidth=0.8, label="Park signal [%]")
    right.plot(time, 100.0 * run.result.columns["controller.duty"], color=RED, linewidth=1.0, label="Motor voltage [%]")
    axes.plot(time, run.result.columns["controller.i_filtered"], color=BLUE, linewidth=1.6, label="Motor current [A]")
    # a little more than the source's 3 A and 100 %, so that full voltage is seen
    axes.set(xlim=(0, 10), ylim=(0, 3.06), xlabel="Time [s]", ylabel="Current [A]", xticks=range(11))
    right.set(ylim=(0, 102), ylabel="Ratio [%]", yticks=range(0, 101, 10))
    axes.set_zorder(right.get_zorder() + 1)
    axes.patch.set_visible(False)
    handles = [*axes.get_lines(), *reversed(right.get_lines())]
    _legend(axes, handles)
    _save(figure, path)


def passenger_side(runs: Mapping[str, Result], path: Path) -> None:
    """Figure 3.5: position, speed and torque of the passenger side's rocker; the naive load, as the source shows it."""
    result = runs["naive"]
    figure, axes = _figure("Physical quantities, passenger side")
    # the model's angle counts from the x axis, the source's from where the rocker stands at the start
    position = result.columns["plant.phi_ps"] - result.columns["plant.phi_ps"][0]
    axes.plot(result.time, position, color=BLUE, label="Position PS [rad]")
    axes.plot(result.time, result.columns["plant.w_ps"], color=RED, linestyle="--", label="Velocity PS [rad/s]")
    axes.plot(result.time, result.columns["plant.tau_ps"], color=GREEN, linestyle="-.", label="Torque PS [Nm]")
    axes.set(xlim=(0, 8), ylim=(-10, 15), xlabel="Time [s]")
    _legend(axes, axes.get_lines())
    _save(figure, path)


def motor_torque(runs: Mapping[str, Result], path: Path) -> None:
    """Figure 3.6 without its measured curve: the torque at the gear's output with both loads."""
    figure, axes = _figure("Motor torque")
    styles = {"naive": (BLUE, "-"), "simple": (RED, "--")}
    for load, (colour, style) in styles.items():
        result = runs[load]
        label = f"Modelled motor torque, {load} load"
        axes.plot(result.time, result.columns["plant.tau_crank"], color=colour, linestyle=style, label=label)
    axes.set(xlim=(0, 8), ylim=(-5, 40), xlabel="Time [s]", ylabel="Torque [Nm]")
    _legend(axes, axes.get_lines())
    _save(figure, path)


def voltage_profile(result: Result, path: Path) -> None:
    """Figure 3.12: the profile's output, coloured by its state; full voltage is one."""
    figure, axes = _figure("Voltage trajectory profile")
    states = np.array(["", *result.literals["controller.state"]])[result.columns["controller.state"]]
    # an enumeration's values count from 1
    duty, time = result.columns["controller.duty"], result.time
    for state, colour in STATE_COLOURS.items():
        # each stretch with the row after it, so that no gaps show between the states
        inside = states == state
        shown = inside | np.concatenate([[False], inside[:-1]])
        if inside.any():
            label = STATE_NAMES.get(state, state)
            axes.plot(time, np.where(shown, duty, np.nan), color=colour, linewidth=2.2, label=label)
    axes.set(xlim=(0, 4), ylim=(0, 1.05), xlabel="Time [s]", ylabel="Voltage, full voltage = 1")
    _legend(axes, axes.get_lines())
    _save(figure, path)


def _figure(title: str) -> tuple[Figure, Axes]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 4.5), dpi=110, layout="constrained")
    axes = figure.add_subplot()
    axes.set_title(title, fontsize=12)
    axes.grid(alpha=0.25)
    return figure, axes


def _legend(axes: Axes, handles: Sequence[Artist]) -> None:
    axes.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=5, fontsize=8, frameon=False)


def _save(figure: Figure, path: Path) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    # unlike savefig, which draws once more to measure, this draws once
    FigureCanvasAgg(figure).print_png(str(path), pil_kwargs={"compress_level": 1})  # type: ignore[no-untyped-call]

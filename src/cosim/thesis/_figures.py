"""The source's figures with its axes, labels and units, so that they can be laid beside it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from cosim.colours import BLUE, GREEN, ORANGE, PINK, RED
from cosim.engine import Result
from cosim.thesis._canvas import GREY, canvas, legend, save
from cosim.thesis._kinematics import Drawing
from cosim.thesis._measured import Measured
from cosim.thesis._pwm import Pwm
from cosim.thesis._runs import RigRun

STATE_COLOURS = {
    "Soft_start": GREEN,
    "RUN": BLUE,
    "turn_point_dec": RED,
    "turn_point_acc": ORANGE,
    "Soft_stop": PINK,
    "IDLE": GREY,
}
STATE_NAMES = {
    "RUN": "RUN.RUN",
    "turn_point_dec": "RUN.turn_point_dec",
    "turn_point_acc": "RUN.turn_point_acc",
}
"""As the legend of figure 3.12 calls them."""


def system_performance(run: RigRun, path: Path) -> None:
    """Figures 4.9 to 4.18: filtered current on the left, motor voltage and park signal in percent on the right."""
    shown = run.result.time <= 10.0
    time = run.result.time[shown]
    columns = {name: values[shown] for name, values in run.result.columns.items()}
    figure, (axes,) = canvas(f"System performance, {run.load} load")
    right = axes.twinx()
    right.plot(time, 100.0 * columns["plant.park"], color=GREY, linewidth=0.8, label="Park signal [%]")
    right.plot(time, 100.0 * columns["controller.duty"], color=RED, linewidth=1.0, label="Motor voltage [%]")
    axes.plot(time, columns["controller.i_filtered"], color=BLUE, linewidth=1.6, label="Motor current [A]")
    # a little more than the source's 3 A and 100 %, so that full voltage is seen
    axes.set(xlim=(0, 10), ylim=(0, 3.06), xlabel="Time [s]", ylabel="Current [A]", xticks=range(11))
    right.set(ylim=(0, 102), ylabel="Ratio [%]", yticks=range(0, 101, 10))
    axes.set_zorder(right.get_zorder() + 1)
    axes.patch.set_visible(False)
    handles = [*axes.get_lines(), *reversed(right.get_lines())]
    legend(axes, handles)
    save(figure, path)


def passenger_side(runs: Mapping[str, Result], path: Path) -> None:
    """Figure 3.5: position, speed and torque of the passenger side's rocker; the naive load, as the source shows it."""
    result = runs["naive"]
    figure, (axes,) = canvas("Physical quantities, passenger side")
    # the model's angle counts from the x axis, the source's from where the rocker stands at the start
    position = result.columns["plant.phi_ps"] - result.columns["plant.phi_ps"][0]
    axes.plot(result.time, position, color=BLUE, label="Position PS [rad]")
    axes.plot(result.time, result.columns["plant.w_ps"], color=RED, linestyle="--", label="Velocity PS [rad/s]")
    axes.plot(result.time, result.columns["plant.tau_ps"], color=GREEN, linestyle="-.", label="Torque PS [Nm]")
    axes.set(xlim=(0, 8), ylim=(-10, 15), xlabel="Time [s]")
    legend(axes)
    save(figure, path)


def motor_torque(runs: Mapping[str, Result], measured: Measured | None, path: Path) -> None:
    """Figure 3.6: the torque at the gear's output with both loads, and the measured curve if there is one."""
    figure, (axes,) = canvas("Motor torque")
    if measured is not None:
        axes.plot(measured.time, measured.torque, color=BLUE, linewidth=0.9, label=measured.label)
    # in the source measured is blue and modelled red
    styles = {"naive": (RED, "-"), "simple": (GREEN, "--")}
    for load, (colour, style) in styles.items():
        result = runs[load]
        label = f"Modelled motor torque, {load} load"
        axes.plot(result.time, result.columns["plant.tau_crank"], color=colour, linestyle=style, label=label)
    axes.set(xlim=(0, 8), ylim=(-5, 40), xlabel="Time [s]", ylabel="Torque [Nm]")
    legend(axes)
    save(figure, path)


def voltage_profile(result: Result, path: Path) -> None:
    """Figure 3.12: the profile's output, coloured by its state; full voltage is one."""
    figure, (axes,) = canvas("Voltage trajectory profile")
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
    legend(axes)
    save(figure, path)


def pulse_width(pwm: Pwm, path: Path) -> None:
    """Figure 4.8: the current after a step down of the voltage, at three frequencies of the bridge."""
    figure, (axes,) = canvas("PWM performance")
    run = pwm.runs["1khz"]
    rows = run.columns["plant.i_motor"][: len(run.time) // 50 * 50].reshape(-1, 50)
    start = run.time[: rows.size : 50]
    band = axes.fill_between(
        start, rows.min(axis=1), rows.max(axis=1), color=ORANGE, alpha=0.7, linewidth=0.5, label="T$_s$ = 1 ms"
    )
    lines = []
    for name, colour, width, label in (
        ("10hz", "#444444", 0.8, "T$_s$ = 100 ms"),
        ("100khz", GREEN, 2.0, "T$_s$ = 0.01 ms"),
    ):
        run, stride = pwm.runs[name], 27 if name == "100khz" else 1
        lines += axes.plot(
            run.time[::stride], run.columns["plant.i_motor"][::stride], color=colour, linewidth=width, label=label
        )
    averaged = pwm.runs["averaged"]
    current, duty = averaged.columns["plant.i_motor"], averaged.columns["plant.duty"]
    lines += axes.plot(averaged.time, current, "k:", linewidth=1.2, label="averaged bridge")
    lines += axes.plot(averaged.time, duty, color=BLUE, linestyle="--", label="Voltage profile, full voltage = 1")
    axes.set(xlim=(0, 4.5), ylim=(0, 3.5), xlabel="Time [s]", ylabel="Current [A]")
    legend(axes, [lines[1], band, lines[0], *lines[2:]])
    save(figure, path)


def pulse_width_means(pwm: Pwm, path: Path) -> None:
    """Where the mean currents of the switched and the averaged bridge part: the mean of each period against it."""
    figure, (axes,) = canvas(f"Mean current of the switched bridge, duty ratio {pwm.duty:g}", size=(7.5, 5.0))
    for name, colour, marker, label in (
        ("10hz", GREY, "s", "10 Hz"), ("1khz", ORANGE, ".", "1 kHz"), ("100khz", GREEN, ".", "100 kHz")
    ):  # fmt: skip
        found = pwm.periods(name)
        axes.plot(found.averaged, found.mean, marker, color=colour, markersize=4, label=f"{label}, simulated")
    machine, d = pwm.machine, pwm.duty
    averaged = np.linspace(-3.4, 1.4, 400)
    mean = machine.mean(d, 1e-3, d * machine.V - machine.R * averaged)
    axes.plot(averaged, mean, "k-", linewidth=0.9, label="1 kHz, closed form")
    axes.plot(averaged, np.maximum(averaged, 0.0), color=BLUE, linestyle="--", label="averaged bridge")
    half = machine.half_ripple(d, 1e-3)
    axes.axvline(half, color="k", linestyle=":", label=f"half the ripple at 1 kHz, {half:.2f} A")
    axes.set(xlim=(-4.3, 1.45), ylim=(0, 1.5), ylabel="mean over a period [A]")
    axes.set_xlabel("(d V - E)/R at the speed of the period [A]")
    legend(axes, columns=3)
    save(figure, path)


def wiper_system(drawing: Drawing, path: Path) -> None:
    """The analytic plot of B.2.4: circles of the joints, one position of the linkage, all positions of the wipers."""
    figure, (axes,) = canvas("Wiper system, analytic plot (B.2.4)", size=(9.0, 5.2))
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    ring = np.stack([np.cos(turn), np.sin(turn)])
    crank = np.arange(0.0, 2.0 * np.pi, np.pi / 20)
    shown = np.array([2.0])
    pin = 1e3 * drawing.ds.pin(shown)[:, 0]
    axes.plot(*(1e3 * drawing.ds.a * ring), color=GREY, linestyle="--", linewidth=1.0, label="circles of C and D")
    for side, colour, name in ((drawing.ps, RED, "PS"), (drawing.ds, BLUE, "DS")):
        ground = 1e3 * np.reshape(side.ground, (2, 1))
        axes.plot(*(ground + 1e3 * side.b * ring), color=GREY, linestyle="--", linewidth=1.0)
        inner, outer = (1e3 * points for points in side.wiper_points(crank))
        # one line with gaps: many lines take long to draw
        gaps = np.full_like(inner, np.nan)
        axes.plot(*np.stack([inner, outer, gaps], axis=2).reshape(2, -1), color=colour, linewidth=0.5, alpha=0.5)
        axes.plot(*outer, ":", color=colour, linewidth=0.9)
        inner, outer = (1e3 * points[:, 0] for points in side.wiper_points(shown))
        joint = 1e3 * side.joint(shown)[:, 0]
        bars = np.stack([inner, ground[:, 0], joint, pin, [0.0, 0.0]], axis=1)
        axes.plot(
            *bars,
            "o-",
            color="k",
            linewidth=1.4,
            markersize=3,
            label="linkage A-D-C-B-A1, A2" if name == "PS" else None,
        )
        ends = np.stack([inner, outer], axis=1)
        axes.plot(*ends, color=colour, linewidth=2.4, label=f"wiper {'A1-B1' if name == 'PS' else 'A2-B2'} ({name})")
        for text, point in (("C", joint), ("B", ground[:, 0])):
            axes.annotate(
                f"{text}$_{{{name}}}$", tuple(point), xytext=(5, -12 if text == "C" else 6), textcoords="offset points"
            )
        for text, point in zip(("A1", "B1") if name == "PS" else ("A2", "B2"), (inner, outer), strict=True):
            axes.annotate(text, tuple(point), xytext=(4, 5), textcoords="offset points", color=colour)
    axes.annotate("A", (0.0, 0.0), xytext=(-4, -14), textcoords="offset points")
    axes.annotate("D", tuple(pin), xytext=(-4, 6), textcoords="offset points")
    axes.set(xlabel="x [mm]", ylabel="y [mm]", aspect="equal")
    legend(axes, [line for line in axes.get_lines() if not str(line.get_label()).startswith("_")])
    save(figure, path)

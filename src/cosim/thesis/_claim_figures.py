"""Pictures of what the source claims: the numbers of the findings as curves."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cosim.assessment import Method, score
from cosim.colours import BLUE, GREEN, ORANGE, RED
from cosim.engine import Result
from cosim.thesis._canvas import GREY, canvas, legend, save
from cosim.thesis._evidence import Evidence
from cosim.thesis._readings import DIP
from cosim.thesis._runs import RigRun
from cosim.thesis._table import PUBLISHED

Array = NDArray[np.float64]

MEASURES = {
    True: ("start_torque_rate", "start_current_rate", "start_motor_acceleration", "start_pin_acceleration",
           "current_peak", "power_peak", "power_mean"),
    False: ("torque_peak", "torque_peak_to_peak", "torque_rate_peak", "torque_rate_rms", "current_rate_peak",
            "current_rate_rms", "current_deviation", "motor_acceleration_peak", "torque_band_1_10",
            "torque_band_10_100"),
}  # fmt: skip
"""Measures of the whole run, and of what follows the start."""


def acceleration(evidence: Evidence, path: Path) -> None:
    """Figure 1.1: acceleration over time. The source shows the motor's housing, here it is the crank pin."""
    figure, (axes,) = canvas("Acceleration of the crank pin, linkage")
    pair = evidence.pairs["linkage"]
    for run, colour, style, label in (
        (pair.constant, BLUE, "-", "constant voltage"),
        (pair.profile, RED, "--", "voltage profile"),
    ):
        time, rate = _pin_acceleration(run)
        axes.plot(time, rate, color=colour, linestyle=style, linewidth=1.2, label=label)
    axes.set(xlim=(-0.2, 10), ylim=(-15, 10), xlabel="Time [s]", ylabel="Acceleration [m/s$^2$]")
    legend(axes)
    save(figure, path)


def vibration(evidence: Evidence, path: Path) -> None:
    """The ratios of the profile to constant voltage at the same wipe rate."""
    figure, (axes,) = canvas("Voltage profile over constant voltage at the same wipe rate", size=(9.0, 5.6))
    labels: list[str] = []
    for whole, keys in MEASURES.items():
        measures = evidence.pairs["linkage"].measures(whole=whole)[0].measures
        labels += [f"{measures[key].label}{'' if whole else ' (after 2.5 s)'}" for key in keys]
    places = np.arange(len(labels))[::-1]
    for (system, pair), colour, marker in zip(evidence.pairs.items(), (BLUE, RED), ("o", "D"), strict=True):
        ratios = [pair.comparison(whole=whole).ratios[key] for whole, keys in MEASURES.items() for key in keys]
        axes.plot(ratios, places, marker, color=colour, markersize=6, label=system)
    axes.axvline(1.0, color="k", linewidth=1.0)
    axes.set(xscale="log", xlabel="ratio; below 1 the profile lowers it", yticks=places)
    axes.set_yticklabels(labels, fontsize=8)
    axes.legend(loc="upper right", fontsize=8)
    save(figure, path)


def load(evidence: Evidence, path: Path) -> None:
    """Crank torque over the crank angle, and the part of it that the external load takes."""
    figure, (axes,) = canvas("Crank torque at full voltage, linkage with the simple load")
    run = evidence.linkage["simple"]
    columns = {name.removeprefix("plant."): values for name, values in run.columns.items()}
    turned = columns["phi_crank"] / (2.0 * np.pi)
    rows = (turned >= 2.0) & (turned < 4.0)
    taken = columns["tau_ds"] * columns["w_ds"] + columns["tau_ps"] * columns["w_ps"]
    angle = 360.0 * (turned[rows] - 2.0)
    axes.plot(angle, columns["tau_crank"][rows], color=BLUE, label="torque at the crank")
    part = taken[rows] / columns["w_crank"][rows]
    axes.plot(angle, part, color=RED, linestyle="--", label="the external load's part")
    found = evidence.budgets["with"]
    axes.axhline(found.torque, color=BLUE, linewidth=0.8, linestyle=":", label=f"mean {found.torque:.1f} N.m")
    axes.axhline(found.load_torque, color=RED, linewidth=0.8, linestyle=":", label=f"mean {found.load_torque:.1f} N.m")
    axes.set(xlim=(0, 720), ylim=(0, 16), xticks=range(0, 721, 90), xlabel="Crank angle [deg]", ylabel="Torque [N.m]")
    legend(axes)
    save(figure, path)


def sampling(evidence: Evidence, path: Path) -> None:
    """Parks predicted over the sampling time, and where the profile turns over the length of the minimum's window."""
    figure, (left, right) = canvas("What the sampling time of the current changes", columns=2, size=(10.0, 4.6))
    for load_name, fill in (("normal", True), ("disturbed", False)):
        for colour, marker, label, shares in (
            (GREY, "s", "published", _published(load_name)),
            (BLUE, "o", "Soft_stop Ts/2", _simulated(evidence.rig, load_name)),
            (RED, "D", "Soft_stop Ts", _simulated(evidence.rig_full_stop, load_name)),
        ):
            face = colour if fill else "white"
            left.plot(
                [1e3 * time for time in shares], [100.0 * share for share in shares.values()], marker, color=colour,
                markerfacecolor=face, linestyle="-" if fill else ":", linewidth=1.0, label=f"{label}, {load_name}",
            )  # fmt: skip
    left.plot(
        [1e3 * unit.period for unit in evidence.slow], [100.0 * unit.seen / unit.contacts for unit in evidence.slow],
        "x", color="k", markersize=8, markeredgewidth=2, label="contacts seen, all at one rate",
    )  # fmt: skip
    left.set(xscale="log", xlabel="sampling time [ms]", ylabel="park signals in the dip of the voltage [%]")
    left.set(ylim=(-4, 104), xticks=[1, 2, 10, 20, 50], xticklabels=["1", "2", "10", "20", "50"])
    left.minorticks_off()
    legend(left, columns=2)
    for time, colour, marker in ((0.001, BLUE, "o"), (0.002, GREEN, "v"), (0.01, ORANGE, "s"), (0.02, RED, "D"),
                                 (0.05, GREY, "^")):  # fmt: skip
        turns = [turn for turn in evidence.turns if turn.sample_time == time]
        for turn in turns:
            right.plot(
                turn.window, turn.share, marker, color=colour, markersize=7, label=f"{1e3 * time:.0f} ms",
                markerfacecolor=colour if turn.n_window == 50 else "white",
            )  # fmt: skip
    handles = {str(line.get_label()): line for line in reversed(right.get_lines())}
    right.set(xscale="log", xlabel="window of the least current [s]; 50 samples are filled")
    right.set(ylabel="turn, share of the revolution")
    legend(right, list(handles.values())[::-1])
    save(figure, path)


def disturbance(evidence: Evidence, path: Path) -> None:
    """The crank's speed after a push, with and without it, at the same crank angles."""
    pushed = [case for case in evidence.aftermaths if case.name.endswith("pushed")]
    figure, axes = canvas("Rig, pushed with 5 N.m for 0.3 s", rows=len(pushed), size=(9.0, 6.0))
    for axis, case in zip(axes, pushed, strict=True):
        axis.plot(case.angle, case.speeds[1], color=RED, linewidth=1.2, label="pushed")
        axis.plot(case.angle, case.speeds[0], color="k", linestyle="--", linewidth=1.0, label="not pushed")
        axis.set_title(case.name.removesuffix(", pushed"), fontsize=9, loc="left")
        axis.set(xlim=(0, case.angle[-1]), ylabel="speed [rad/s]")
    axes[0].legend(loc="upper right", fontsize=8, ncols=2)
    axes[-1].set_xlabel("revolutions of the crank since the push began")
    save(figure, path)


def _pin_acceleration(run: Result) -> tuple[Array, Array]:
    """Return times [s] and the mean acceleration over the window before them [m/s2], as `vibration` measures it."""
    method = Method()
    rows = round(method.window / float(run.time[1] - run.time[0]))
    speed = run.columns["plant.w_crank"].astype(np.float64)
    return run.time[rows:], method.radius * (speed[rows:] - speed[:-rows]) / method.window


def _published(load_name: str) -> dict[float, float]:
    found = {}
    for (time, name), (park, _) in PUBLISHED.items():
        if name == load_name:
            passed, total = map(int, park.split("/"))
            found[time] = passed / total
    return found


def _simulated(runs: Sequence[RigRun], load_name: str) -> dict[float, float]:
    found = {}
    for run in runs:
        if run.load == load_name:
            counts = score(run.result, DIP.rules).counts
            found[run.sample_time] = counts.park_deceleration / counts.park_total
    return found

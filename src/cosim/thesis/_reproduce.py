"""Everything that ``cosim thesis`` makes, in one call."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from cosim.assessment import Rules
from cosim.engine import Fmu
from cosim.thesis import _figures as figures
from cosim.thesis._kinematics import drawing
from cosim.thesis._measured import read_measured
from cosim.thesis._parameters import parameters, write_parameters
from cosim.thesis._pwm import pwm_runs
from cosim.thesis._readings import chosen
from cosim.thesis._runs import FULL_STOP, Locate, RigRun, linkage_runs, profile_run, rig_runs
from cosim.thesis._table import write_readings, write_table

NUMBERS = {
    (0.001, "normal"): "4_9",
    (0.001, "disturbed"): "4_10",
    (0.002, "normal"): "4_11",
    (0.002, "disturbed"): "4_12",
    (0.010, "normal"): "4_13",
    (0.010, "disturbed"): "4_14",
    (0.020, "normal"): "4_15",
    (0.020, "disturbed"): "4_16",
    (0.050, "normal"): "4_17",
    (0.050, "disturbed"): "4_18",
}
"""The source's figures of the rig, by sampling time [s] and load."""


@dataclass(frozen=True)
class Reproduction:
    """What was made: the files in the order of the source, and the runs of the rig with their scores."""

    files: tuple[Path, ...]
    rig: tuple[RigRun, ...]


def reproduce(
    out: Path,
    scenarios: Path,
    locate: Locate,
    *,
    rules: Rules | None = None,
    measured: Path | None = None,
    say: Callable[[str], None] = lambda _: None,
) -> Reproduction:
    """Simulate what the source shows and write its figures and tables into ``out``.

    Args:
        out: a folder, made if it is missing.
        scenarios: the folder of the shipped scenarios.
        locate: gives the FMU of a built-in plant or controller.
        rules: how table 4.1 is read beside the strict reading; by default as a plot shows it.
        measured: a CSV or Parquet table with the columns time and torque, drawn in figure 3.6.
        say: is told what comes next.

    Raises:
        InputError: the measured table cannot be read.
        CosimError: an FMU cannot be built, or a simulation fails.
    """
    curve = None if measured is None else read_measured(measured)
    reading = chosen(rules)
    out.mkdir(parents=True, exist_ok=True)
    files: list[Path] = []

    def place(name: str) -> Path:
        files.append(out / name)
        return files[-1]

    say("the linkage")
    linkage = linkage_runs(scenarios, locate)
    figures.wiper_system(drawing(Fmu.read(locate("linkage"))), place("wiper_system.png"))
    figures.passenger_side(linkage, place("figure_3_5.png"))
    figures.motor_torque(linkage, curve, place("figure_3_6.png"))
    figures.voltage_profile(profile_run(locate), place("figure_3_12.png"))
    say("figure 4.8, the switched bridge")
    pwm = pwm_runs(scenarios, locate)
    figures.pulse_width(pwm, place("figure_4_8.png"))
    figures.pulse_width_means(pwm, place("figure_4_8_means.png"))
    say("figures 4.9 to 4.18 and table 4.1")
    rig = rig_runs(scenarios, locate)
    for run in rig:
        figures.system_performance(run, place(f"figure_{NUMBERS[run.sample_time, run.load]}.png"))
    write_table(rig, reading, place("table_4_1.csv"))
    charts = {"Ts/2": rig, "Ts": rig_runs(scenarios, locate, FULL_STOP)}
    write_readings(charts, reading, place("table_4_1_readings.csv"))
    write_parameters(parameters(scenarios, locate), place("parameters.csv"))
    return Reproduction(tuple(files), tuple(rig))

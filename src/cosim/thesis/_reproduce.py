"""Everything that ``cosim thesis`` makes, in one call."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cosim.thesis import _figures as figures
from cosim.thesis._runs import Locate, RigRun, linkage_runs, profile_run, rig_runs
from cosim.thesis._table import write_table

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


def reproduce(out: Path, scenarios: Path, locate: Locate) -> Reproduction:
    """Simulate what the source shows and write its figures and table 4.1 into ``out``.

    Args:
        out: a folder, made if it is missing.
        scenarios: the folder of the shipped scenarios.
        locate: gives the FMU of a built-in plant or controller.

    Raises:
        CosimError: an FMU cannot be built, or a simulation fails.
    """
    out.mkdir(parents=True, exist_ok=True)
    linkage, profile, rig = linkage_runs(scenarios, locate), profile_run(locate), rig_runs(scenarios, locate)
    figures.passenger_side(linkage, out / "figure_3_5.png")
    figures.motor_torque(linkage, out / "figure_3_6.png")
    figures.voltage_profile(profile, out / "figure_3_12.png")
    files = [out / f"figure_{number}.png" for number in ("3_5", "3_6", "3_12")]
    for run in rig:
        files.append(out / f"figure_{NUMBERS[run.sample_time, run.load]}.png")
        figures.system_performance(run, files[-1])
    files.append(out / "table_4_1.csv")
    write_table(rig, files[-1])
    return Reproduction(tuple(files), tuple(rig))

"""Everything that ``cosim thesis`` makes, in one call."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from cosim.assessment import Rules
from cosim.engine import Fmu
from cosim.thesis import _claim_figures as claim_figures
from cosim.thesis import _figures as figures
from cosim.thesis._claims import Finding, judge
from cosim.thesis._evidence import gather
from cosim.thesis._kinematics import drawing
from cosim.thesis._measured import read_measured
from cosim.thesis._numbers import NUMBERS
from cosim.thesis._page import claims_page, thesis_page
from cosim.thesis._parameters import parameters, write_parameters
from cosim.thesis._readings import chosen
from cosim.thesis._runs import Locate, RigRun
from cosim.thesis._sensitivity_report import Sensitivity, sensitivity
from cosim.thesis._table import write_readings, write_table


@dataclass(frozen=True)
class Reproduction:
    """What was made: files, the runs of the rig with their scores, what was found of the claims, the open choices."""

    files: tuple[Path, ...]
    rig: tuple[RigRun, ...]
    findings: tuple[Finding, ...]
    varied: Sensitivity | None = None


def reproduce(
    out: Path,
    scenarios: Path,
    locate: Locate,
    *,
    rules: Rules | None = None,
    measured: Path | None = None,
    sensitive: bool = False,
    say: Callable[[str], None] = lambda _: None,
) -> Reproduction:
    """Simulate what the source shows and write its figures and tables into ``out``.

    Args:
        out: a folder, made if it is missing.
        scenarios: the folder of the shipped scenarios.
        locate: gives the FMU of a built-in plant or controller.
        rules: how table 4.1 is read beside the strict reading; by default as a plot shows it.
        measured: a measurement with time and torque, drawn in figure 3.6.
        sensitive: whether what the source leaves open is varied, too.
        say: is told what comes next.

    Raises:
        InputError: the measurement cannot be read.
        CosimError: an FMU cannot be built, or a simulation fails.
    """
    curve = None if measured is None else read_measured(measured)
    out.mkdir(parents=True, exist_ok=True)
    locate = cache(locate)  # it looks each time whether the FMU is up to date
    varied = sensitivity(out, scenarios, locate, say=say) if sensitive else None
    evidence = gather(scenarios, locate, chosen(rules), say)
    files: list[Path] = [] if varied is None else list(varied.files)

    def place(name: str) -> Path:
        files.append(out / name)
        return files[-1]

    say("the pictures")
    figures.wiper_system(drawing(Fmu.read(locate("linkage"))), place("wiper_system.png"))
    claim_figures.acceleration(evidence, place("figure_1_1.png"))
    figures.passenger_side(evidence.linkage, place("figure_3_5.png"))
    figures.motor_torque(evidence.linkage, curve, place("figure_3_6.png"))
    figures.voltage_profile(evidence.profile, place("figure_3_12.png"))
    figures.pulse_width(evidence.pwm, place("figure_4_8.png"))
    figures.pulse_width_means(evidence.pwm, place("figure_4_8_means.png"))
    for run in evidence.rig:
        figures.system_performance(run, place(f"figure_{NUMBERS[run.sample_time, run.load]}.png"))
    claim_figures.vibration(evidence, place("claim_vibration.png"))
    claim_figures.load(evidence, place("claim_load.png"))
    claim_figures.sampling(evidence, place("claim_sampling.png"))
    claim_figures.disturbance(evidence, place("claim_disturbance.png"))

    say("the tables and pages")
    write_table(evidence.rig, evidence.reading, place("table_4_1.csv"))
    charts = {"Ts/2": evidence.rig, "Ts": evidence.rig_full_stop}
    write_readings(charts, evidence.reading, place("table_4_1_readings.csv"))
    table = parameters(scenarios, locate)
    write_parameters(table, place("parameters.csv"))
    findings = judge(evidence)
    place("thesis.md").write_text(thesis_page(evidence, findings, table, curve), encoding="utf-8")
    place("claims.md").write_text(claims_page(findings), encoding="utf-8")
    return Reproduction(tuple(files), tuple(evidence.rig), tuple(findings), varied)

"""Prints the table of docs/scoring.md: the vibration of the voltage profile, and of constant voltage at its wipe rate.

Run with ``python docs/vibration_comparison.py`` from a checkout.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from scipy.optimize import brentq

from cosim.assessment import Method, Vibration, compare, vibration
from cosim.engine import Result, simulate
from cosim.fmu import catalogue
from cosim.scenario import assemble, read

SCENARIOS = Path(__file__).parents[1] / "scenarios"
SETTLED = 2.5
"""When the start and the first revolution, in which the period is learned, are over [s]."""
WHOLE = (
    "start_torque_rate",
    "start_current_rate",
    "start_motor_acceleration",
    "start_pin_acceleration",
    "current_peak",
    "power_peak",
    "power_mean",
)
AFTER = (
    "torque_peak",
    "torque_rms",
    "torque_peak_to_peak",
    "torque_rate_peak",
    "torque_rate_rms",
    "current_peak_to_peak",
    "current_rate_peak",
    "current_rate_rms",
    "current_deviation",
    "motor_acceleration_peak",
    "motor_acceleration_rms",
    "turn_torque_peak_to_peak_mean",
    "turn_torque_rate_mean",
    "turn_current_rate_mean",
    "torque_band_1_10",
    "torque_band_10_100",
)


def main() -> None:
    """Print the table as Markdown."""
    print("\n".join(table()))


def table() -> list[str]:
    """Return the lines: for each measure its value under the profile, under constant voltage, and their ratio."""
    columns: list[list[str]] = [["", "|---|", *WHOLE, *AFTER]]
    for system in ("linkage", "rig"):
        profile = run(SCENARIOS / f"{system}_20ms.csv")
        duty = matching_duty(system, vibration(profile)["revolution_time"])
        constant = constant_voltage(system, duty)
        found: list[tuple[str, Vibration, Vibration]] = []
        for keys, method in ((WHOLE, Method()), (AFTER, Method(since=SETTLED))):
            pair = vibration(profile, method), vibration(constant, method)
            found += [(key, *pair) for key in keys]
        head = f"{system}: profile | duty {duty:.3f} | ratio"
        cells = [f"{a[key]:.3g} | {b[key]:.3g} | {compare(a, b).ratios[key]:.2f}" for key, a, b in found]
        columns.append([head, "---:|---:|---:|", *cells])
        columns[0][2:] = [f"{a.measures[key].label} [{a.measures[key].unit}]" for key, a, _ in found]
    rows = [f"| {a} | {b} | {c} |" for a, b, c in zip(*columns, strict=True)]
    rows[1] = "".join(column[1] for column in columns)
    return rows


def matching_duty(system: str, revolution: float) -> float:
    """Return the constant duty ratio at which a revolution takes ``revolution`` [s]."""

    def excess(duty: float) -> float:
        return vibration(constant_voltage(system, duty))["revolution_time"] - revolution

    return float(brentq(excess, 0.9, 1.0, xtol=1e-4))


def constant_voltage(system: str, duty: float) -> Result:
    """Run the plant as today's production does: the voltage is switched on and stays."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "constant.csv"
        file.write_text(f"# system: {system}\n# controller: none\n# stop: 25 s\ntime [s],duty [1]\n0,0\n0,{duty!r}\n")
        return run(file)


def run(file: Path) -> Result:
    """Simulate a scenario."""
    scenario = read(file)
    system = assemble(scenario, catalogue.ensure)
    return simulate(system, stop=scenario.stop, output_interval=scenario.output_interval, tolerance=scenario.tolerance)


if __name__ == "__main__":
    main()

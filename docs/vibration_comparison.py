"""Prints the table of docs/scoring.md: the vibration of the voltage profile, and of constant voltage at its wipe rate.

Run with ``python docs/vibration_comparison.py`` from a checkout.
"""

from __future__ import annotations

from pathlib import Path

from cosim.assessment import Vibration, compare
from cosim.fmu import catalogue
from cosim.thesis import same_rate

SCENARIOS = Path(__file__).parents[1] / "scenarios"
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
    for system, pair in same_rate(SCENARIOS, catalogue.ensure).items():
        found: list[tuple[str, Vibration, Vibration]] = []
        for keys, whole in ((WHOLE, True), (AFTER, False)):
            found += [(key, *pair.measures(whole=whole)) for key in keys]
        head = f"{system}: profile | duty {pair.duty:.3f} | ratio"
        cells = [f"{a[key]:.3g} | {b[key]:.3g} | {compare(a, b).ratios[key]:.2f}" for key, a, b in found]
        columns.append([head, "---:|---:|---:|", *cells])
        columns[0][2:] = [f"{a.measures[key].label} [{a.measures[key].unit}]" for key, a, _ in found]
    rows = [f"| {a} | {b} | {c} |" for a, b, c in zip(*columns, strict=True)]
    rows[1] = "".join(column[1] for column in columns)
    return rows


if __name__ == "__main__":
    main()

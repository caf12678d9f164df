"""The scenarios that come with the package can be read, and say what they show."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from cosim.scenario import read
from cosim.scenario.disturbance import Pulses, rows

FOLDER = Path(__file__).parents[2] / "scenarios"


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.csv")), ids=lambda path: path.stem)
def test_it_reads_and_has_a_title(path: Path) -> None:
    scenario = read(path)
    assert scenario.title
    assert scenario.stop == (4.5 if "_pwm_" in path.stem else 25.0)
    assert "\n## Shows " in path.read_text(encoding="utf-8")


def test_full_voltage_is_a_step_after_initialisation() -> None:
    (duty,) = read(FOLDER / "rig_full_voltage.csv").columns
    assert (duty.times, duty.values) == ((0.0, 0.0), (0.0, 1.0))


def test_the_disturbance_brakes_and_pushes_in_turn_and_ends() -> None:
    (torque,) = read(FOLDER / "linkage_disturbed.csv").columns
    assert torque.values == (0.0, *(-5.0, 0.0, 5.0, 0.0) * 4)
    pulses = list(zip(torque.times[1::2], torque.times[2::2], strict=True))
    assert [end - start for start, end in pulses] == pytest.approx([0.3] * 8)
    assert [start for start, _ in pulses] == [3, 6, 9, 12, 15, 18, 21, 24]


def test_the_readme_lists_every_scenario_once() -> None:
    text = (FOLDER / "README.md").read_text(encoding="utf-8")
    listed = re.findall(r"^\| \[(\w+)\]\((\w+)\.csv\) \|", text, re.MULTILINE)
    assert all(name == file for name, file in listed)
    assert sorted(name for name, _ in listed) == sorted(path.stem for path in FOLDER.glob("*.csv"))


@pytest.mark.parametrize("ms", [1, 2, 10, 20, 50])
def test_the_disturbed_runs_of_table_4_1_are_the_normal_ones_with_the_pulses_of_seed_1(ms: int) -> None:
    normal, disturbed = (read(FOLDER / f"rig_{ms}ms{kind}.csv") for kind in ("", "_disturbed"))
    (torque,) = disturbed.columns
    assert list(zip(torque.times, torque.values, strict=True)) == rows(Pulses(seed=1), 25.0)
    assert normal.sample_time == disturbed.sample_time == pytest.approx(ms * 1e-3)
    for scenario in (normal, disturbed):
        settings = {setting.name: setting.value for setting in scenario.settings}
        assert settings == {"controller.T_filter": "0.125 s", "controller.duty_min": "0.35"}
        assert (scenario.system, scenario.controller, scenario.tolerance) == ("rig", "voltage_profile", 1e-8)

"""The scenarios that come with the package can be read, and say what they show."""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim.scenario import read

FOLDER = Path(__file__).parents[2] / "scenarios"


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.csv")), ids=lambda path: path.stem)
def test_it_reads_and_has_a_title(path: Path) -> None:
    scenario = read(path)
    assert scenario.title
    assert scenario.stop == 25.0
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

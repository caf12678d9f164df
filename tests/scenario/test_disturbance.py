"""Seeded pulses: as many, as long, as large and as far apart as asked for; the same for one seed."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from cosim.errors import InputError
from cosim.scenario import read
from cosim.scenario.disturbance import Pulses, numbers, rows, text

SCENARIOS = Path(__file__).parents[2] / "scenarios"


def test_pulses_brake_and_push_by_turns_within_their_bounds() -> None:
    pulses = Pulses(size=4.0, length=0.25, spacing=2.0, variation=0.3, seed=5)
    table = np.array(rows(pulses, 4000.0))
    assert tuple(table[0]) == (0.0, 0.0)
    starts, ends = table[1::2], table[2::2]
    assert np.all(ends[:, 1] == 0)
    assert np.all(np.sign(starts[:, 1]) == np.resize([-1, 1], len(starts)))
    length = ends[:, 0] - starts[: len(ends), 0]
    gap = np.diff(starts[:, 0], prepend=0.0)
    for values, mean in ((np.abs(starts[:, 1]), 4.0), (length, 0.25), (gap, 2.0)):
        assert np.all(np.abs(values - mean) <= 0.3 * mean + 0.0051)
        # evenly distributed: deviation and mean within four standard errors
        sigma = 0.3 * mean / np.sqrt(3)
        assert values.mean() == pytest.approx(mean, abs=4 * sigma / np.sqrt(len(values)))
        assert values.std() == pytest.approx(sigma, rel=4 / np.sqrt(len(values)))
    assert np.abs(np.corrcoef(gap[:-1], gap[1:])[0, 1]) < 4 / np.sqrt(len(gap))


def test_without_variation_the_pulses_are_periodic() -> None:
    assert rows(Pulses(variation=0.0), 10.0) == [
        (0.0, 0.0), (3.0, -5.0), (3.3, 0.0), (6.0, 5.0), (6.3, 0.0), (9.0, -5.0), (9.3, 0.0),
    ]  # fmt: skip
    assert rows(Pulses(variation=0.0), 3.2)[-1] == (3.0, -5.0)


def test_the_generator_is_the_published_one() -> None:
    """Against whole numbers of any size, without the order of the operations that keeps the model's exact."""
    state = [1 + (69069 * 9 + 12345) % 2147483562, 1 + (1664525 * 9 + 67890) % 2147483398]
    for found in islice(numbers(9), 1000):
        state = [40014 * state[0] % 2147483563, 40692 * state[1] % 2147483399]
        assert found == ((state[0] - state[1] - 1) % 2147483562 + 1) / 2147483563


def test_a_seed_gives_the_same_text_and_another_seed_another(tmp_path: Path) -> None:
    base = SCENARIOS / "rig_20ms.csv"
    first = text(Pulses(seed=1), 25.0, base)
    assert text(Pulses(seed=1), 25.0, base) == first
    assert text(Pulses(seed=2), 25.0, base) != first
    file = tmp_path / "x.csv"
    file.write_text(first, encoding="utf-8")
    scenario = read(file)
    (column,) = scenario.columns
    assert list(zip(column.times, column.values, strict=True)) == rows(Pulses(seed=1), 25.0)
    assert (scenario.system, scenario.stop, scenario.settings) == ("rig", 25.0, scenario.settings)
    assert {s.name: s.value for s in scenario.settings} == {s.name: s.value for s in read(base).settings}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"size": 0.0}, "the pulses' size is 0 N.m; give a positive one"),
        ({"length": -1.0}, "the pulses' length is -1 s; give a positive one"),
        ({"spacing": float("nan")}, "the pulses' spacing is nan s; give a positive one"),
        ({"variation": 1.0}, "the pulses' variation is 1; give a number from 0 up to, not including, 1"),
        ({"seed": -1}, "the seed is -1; give a whole number from 0 on"),
        (
            {"length": 2.5},
            "a pulse may last 3 s, but the next may start after 2.4 s; "
            "make the pulses shorter, their spacing larger or their variation smaller",
        ),
    ],
)
def test_what_makes_no_pulses_is_refused(change: dict[str, float], message: str) -> None:
    with pytest.raises(InputError) as caught:
        Pulses(**change)  # type: ignore[arg-type]
    assert str(caught.value) == message


def test_a_base_with_rows_of_its_own_is_refused() -> None:
    base = SCENARIOS / "linkage_disturbed.csv"
    with pytest.raises(InputError) as caught:
        text(Pulses(), 25.0, base)
    assert str(caught.value) == (
        f"{base}:8: the base scenario has channels or rows of its own; "
        "give one whose table is the header 'time [s]' alone"
    )

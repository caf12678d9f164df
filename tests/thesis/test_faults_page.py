"""The page on faults: it is what its command makes, and what it concludes is so."""

from __future__ import annotations

import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

pytest.importorskip("rumoca")

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "faults.md"


@pytest.fixture(scope="module")
def study() -> ModuleType:
    spec = spec_from_file_location("faults_study", ROOT / "docs" / "faults.py")
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    sys.modules[spec.name] = module  # its data classes look themselves up there
    spec.loader.exec_module(module)
    return module


def test_the_part_on_the_contact_is_what_the_scenarios_give(study: ModuleType) -> None:
    runs = study.shipped()
    assert study.filled(study.stuck_section(runs)).strip("\n") in PAGE.read_text(encoding="utf-8")
    opened, closed = runs["rig_park_stuck_open"], runs["rig_park_stuck_closed"]
    # a plan is shorter than the two periods that it is made of by half a ramp less a tick; what it drifts is a little
    # less, as the crank, slowed down elsewhere, takes less time for a revolution
    assert np.mean(study.drift(opened)) == pytest.approx(0.049, abs=0.010)
    assert [r.turn for r in opened.revolutions if r.end < study.STUCK[1]] == [True] * 6
    assert not any(r.park_deceleration for r in opened.revolutions if 9.0 < r.end < study.STUCK[1] + 1.0)
    assert not any(r.turn for r in closed.revolutions if study.STUCK[0] < r.end < study.STUCK[1] + 1.0)
    # from the rising edge at 7 s on, half a revolution off: soft stops half a revolution before the contact
    leads = [lead for at, lead in closed.leads if study.STUCK[0] < at < study.STUCK[1]]
    assert leads == pytest.approx([1.0] * len(leads), abs=0.15)
    assert all(r.turn for r in (*opened.revolutions, *closed.revolutions) if r.end > study.STUCK[1] + 4.0)


def test_before_the_fault_the_runs_are_the_healthy_one(study: ModuleType) -> None:
    """To the bit: a fault that has not begun does nothing."""
    healthy = study.Bench.load("rig_20ms").run().result
    for name in ("rig_park_stuck_open", "rig_park_stuck_closed"):
        result = study.Bench.load(name).run().result
        before = result.time < study.STUCK[0] - 1e-6
        for column, values in healthy.columns.items():
            assert np.array_equal(values[before], result.columns[column][before]), column


@pytest.mark.slow
def test_the_page_is_what_its_command_makes(study: ModuleType) -> None:
    sweeps = {name: study.sweep(name) for name in (study.RIG, study.WIPER)}
    assert study.filled(study.page(study.shipped(), sweeps)) == PAGE.read_text(encoding="utf-8")
    rig = sweeps[study.RIG]
    assert study._slope(rig) == pytest.approx(study._speed(rig), rel=0.1)

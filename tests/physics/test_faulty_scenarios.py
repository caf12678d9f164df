"""The scenarios with faults against the independent reference, whose controller is shown what the faults make of it."""

from __future__ import annotations

from collections import deque
from pathlib import Path
from zlib import crc32

import numpy as np
import pytest

from cosim.engine import simulate
from cosim.fmu import catalogue
from cosim.scenario import assemble, read
from reference.closed_loop import ClosedLoop, Sensed, closed_loop
from reference.controller import Parameters
from reference.plant import rig_plant

pytest.importorskip("rumoca")

FOLDER = Path(__file__).parents[2] / "scenarios"
NAMES = ["rig_park_stuck_open", "rig_park_stuck_closed", "rig_noisy_current", "rig_late_current"]


def stuck(value: bool) -> Sensed:
    """The contact from tick 7,000 on, until tick 15,000."""
    return lambda k, current, park: (current, value if 7_000 <= k < 15_000 else park)


def noisy() -> Sensed:
    """The numbers that docs/scenarios.md says a fault draws."""
    seed = np.random.SeedSequence([1, crc32(b"controller.i_motor noise"), 0])
    noise = np.random.Generator(np.random.Philox(seed)).standard_normal(25_001)
    return lambda k, current, park: (current + float(noise[k]), park)


def late() -> Sensed:
    """By 100 ticks; before there was any current, it is none."""
    seen = deque([0.0] * 100)

    def sensed(_: int, current: float, park: bool) -> tuple[float, bool]:
        seen.append(current)
        return seen.popleft(), park

    return sensed


def reference(name: str) -> ClosedLoop:
    sensed = dict(zip(NAMES, (stuck(False), stuck(True), noisy(), late()), strict=True))[name]
    parameters = Parameters(T_sample=0.02, T_filter=0.125, duty_min=0.35)
    return closed_loop(rig_plant(), parameters, stop=25.0, sensed=sensed)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_a_faulty_drive_does_what_the_reference_does(name: str) -> None:
    """Every decision at its tick, every current to 0.1 mA."""
    scenario = read(FOLDER / f"{name}.csv")
    system = assemble(scenario, catalogue.ensure)
    result = simulate(system, stop=25.0, output_interval=1e-3, tolerance=scenario.tolerance)
    expected = reference(name)
    names = [result.literals["controller.state"][number - 1] for number in result.columns["controller.state"]]
    assert [state.value.rpartition(".")[2] for state in expected.states] == [one.rpartition(".")[2] for one in names]
    np.testing.assert_allclose(result.columns["plant.i_motor"], expected.values["i_motor"], rtol=0, atol=1e-4)
    np.testing.assert_allclose(result.columns["plant.phi_crank"], expected.values["phi_crank"], rtol=0, atol=1e-5)

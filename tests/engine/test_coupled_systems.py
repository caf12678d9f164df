"""The plants in parts that other tests use do what their references say, and so do their twins."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from coupled_systems import COUPLED, CoupledSystems, exact

from cosim.engine import Value, simulate


@pytest.mark.parametrize("name", [name for name in COUPLED if name != "displacement"])
def test_the_whole_is_its_reference(coupled: CoupledSystems, name: str) -> None:
    result = simulate(coupled.twin(name), stop=2.0, output_interval=0.02, tolerance=1e-9)
    for output, values in COUPLED[name].reference(result.time).items():
        scale = float(np.ptp(values))
        np.testing.assert_allclose(result.columns[f"whole.{output}"], values, rtol=0, atol=1e-7 * scale, err_msg=output)


@pytest.mark.parametrize(("name", "fmi"), [*((name, 3) for name in COUPLED), ("oscillator", 2)])
def test_the_parts_tend_to_the_whole(coupled: CoupledSystems, name: str, fmi: int) -> None:
    """With held inputs the error falls with the step, and is small beside the signal."""
    version = 2 if fmi == 2 else 3
    errors = []
    for step in (4e-3, 2e-3):
        result = simulate(
            coupled.system(name, version), stop=2.0, output_interval=0.02, tolerance=1e-8, algorithm="jacobi", step=step
        )
        wanted = exact(name, result.time)
        errors.append([np.max(np.abs(result.columns[n] - values)) / np.ptp(values) for n, values in wanted.items()])
    coarse, fine = np.array(errors)
    assert np.all(fine < 0.02)
    np.testing.assert_allclose(coarse / fine, 2.0, rtol=0.1)


def test_long_steps_over_a_stiff_coupling_need_iteration(coupled: CoupledSystems) -> None:
    """As docs/coupling.md tells: by extrapolation the masses fly apart, by agreement at the end of the step not."""
    system, twin = coupled.system("oscillator"), coupled.twin("oscillator")
    stiff: dict[str, Value] = {"c_coupling": 200.0, "d_coupling": 10.0}
    system.components[1].parameters.update(stiff)
    twin.components[0].parameters.update({f"second.{name}": value for name, value in stiff.items()})
    arguments: dict[str, Any] = {"stop": 5.0, "output_interval": 0.1, "tolerance": 1e-9, "coupling_error": False}
    whole = simulate(twin, **arguments).columns["whole.x1"]
    off = {
        algorithm: np.max(
            np.abs(
                simulate(system, algorithm=algorithm, extrapolation=2, step=0.1, **arguments).columns["first.x"] - whole
            )
        )
        for algorithm in ("extrapolated", "iterated")
    }
    assert off["iterated"] < 0.15 * np.ptp(whole)
    assert off["extrapolated"] > 1e6

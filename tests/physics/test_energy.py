"""Conservation of energy: what is supplied is stored or lost somewhere that has a name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from fmpy import simulate_fmu


@pytest.mark.parametrize("model", [pytest.param("LinkageEnergy", marks=pytest.mark.slow), "RigEnergy"])
def test_supplied_energy_is_stored_or_lost_by_name(exported: Callable[[str], Path], model: str) -> None:
    result = simulate_fmu(
        str(exported(f"Tests.{model}")),
        stop_time=3.0,
        output_interval=1e-2,
        relative_tolerance=1e-7,
        output=["E_error", "E_in"],
    )
    supplied = np.abs(result["E_in"]).max()
    assert supplied > 10.0
    assert np.abs(result["E_error"]).max() < 1e-4 * supplied

"""The current input's arithmetic against the circuit that it stands for."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from fmpy import simulate_fmu


def error(fmu: Path, period: float, **parameters: float) -> float:
    """Greatest difference between the samples and the circuit at their instants [A], over a motor's start."""
    result = simulate_fmu(
        str(fmu), stop_time=0.15, output_interval=period, relative_tolerance=1e-9,
        start_values={"T_measure": period, **parameters}, output=["circuit.i", "input_.i_sample"],
    )  # fmt: skip
    # a row at a tick is taken before it, so that a sample shows in the row after its own
    return float(np.abs(result["input_.i_sample"][1:] - result["circuit.i"][:-1]).max())


@pytest.mark.slow
def test_samples_converge_to_the_circuit_with_the_square_of_their_period(exported: Callable[[str], Path]) -> None:
    """What is assumed is a current that is linear between samples.

    That errs by at most h^2/8 of its second derivative, which is greatest at the start, V R/L^2, and the low-pass
    passes on no more than that; the corner where the amplifier reaches its supply spoils nothing.
    """
    fmu = exported("Tests.SenseChain")
    curvature = 28.0 * 1.91 / (3.75e-3 + 2 * 5.7e-6) ** 2
    periods = (1e-3, 2.5e-4, 6.25e-5)
    errors = [error(fmu, period) for period in periods]
    assert all(found < period**2 / 8 * curvature for found, period in zip(errors, periods, strict=True))
    assert errors[2] < errors[1] / 8 < errors[0] / 64


def test_the_circuit_errs_as_its_gain_and_offset(exported: Callable[[str], Path]) -> None:
    result = simulate_fmu(
        str(exported("Tests.SenseChain")), stop_time=0.5, output_interval=0.5, relative_tolerance=1e-9,
        output=["circuit.i", "bridge.i"],
    )  # fmt: skip
    # at rest in the end: the no-load current, through 2 % of gain error and 30 mV at 0.5 V/A
    assert result["circuit.i"][-1] == pytest.approx(1.02 * result["bridge.i"][-1] + 0.03 / 0.5, rel=1e-5)

"""The library's random numbers: the published sequence to the last bit, and the moments that it promises."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from cosim.engine import Component, Fmu, System, simulate
from cosim.scenario.disturbance import numbers

Array = np.ndarray
N = 20000


@pytest.fixture(scope="module")
def sequence(exported: Callable[[str], Path]) -> Callable[[int], tuple[Array, Array]]:
    """(normal, uniform) of the first N periods for a seed."""
    fmu = Fmu.read(exported("Electronics.Noise"))
    found: dict[int, tuple[Array, Array]] = {}

    def sequence(seed: int) -> tuple[Array, Array]:
        if seed not in found:
            system = System([Component("noise", fmu, {"seed": seed, "T": 1e-3})])
            columns = simulate(system, stop=N * 1e-3 - 5e-4, output_interval=1e-3, tolerance=1e-6).columns
            found[seed] = columns["noise.normal"][:N], columns["noise.uniform"][:N]
        return found[seed]

    return sequence


def expected(seed: int) -> Iterator[tuple[float, float]]:
    """The same from whole numbers: L'Ecuyer's generator, twelve numbers for a normal one and one for a uniform one."""
    random = numbers(seed)
    while True:
        twelve = list(islice(random, 12))
        total = twelve[0]
        for number in twelve[1:]:
            total += number
        yield total - 6, next(random)


@pytest.mark.parametrize("seed", [0, 1, 12345, 2**31 - 1])
def test_numbers_are_those_of_whole_number_arithmetic_to_the_last_bit(
    sequence: Callable[[int], tuple[Array, Array]], seed: int
) -> None:
    normal, uniform = np.array(list(islice(expected(seed), 2000))).T
    assert np.array_equal(sequence(seed)[1][:2000], uniform)
    np.testing.assert_allclose(sequence(seed)[0][:2000], normal, atol=1e-14)  # the order of a sum is the compiler's


@pytest.mark.parametrize("seed", [0, 1, 12345])
def test_moments(sequence: Callable[[int], tuple[Array, Array]], seed: int) -> None:
    """Within four standard errors: of a sum of twelve (variance 1, kurtosis 3 - 1.2/12) and of an even distribution."""
    normal, uniform = sequence(seed)
    root = np.sqrt(N)
    kurtosis = 3 - 1.2 / 12
    assert abs(normal.mean()) < 4 / root
    assert normal.var() == pytest.approx(1, abs=4 * np.sqrt(kurtosis - 1) / root)
    assert (normal**3).mean() == pytest.approx(0, abs=4 * np.sqrt(15) / root)
    assert (normal**4).mean() == pytest.approx(kurtosis, abs=4 * np.sqrt(96) / root)
    assert uniform.mean() == pytest.approx(0.5, abs=4 / np.sqrt(12) / root)
    counts = np.bincount((uniform * 50).astype(int), minlength=50)
    chi_squared = ((counts - N / 50) ** 2).sum() / (N / 50)
    assert abs(chi_squared - 49) < 4 * np.sqrt(2 * 49)


def test_numbers_know_nothing_of_each_other(sequence: Callable[[int], tuple[Array, Array]]) -> None:
    """Not of the ones before them, not of the other kind, not of the next seed's."""
    bound = 4.5 / np.sqrt(N)
    normal, uniform = sequence(1)
    for lag in range(1, 31):
        assert abs(np.corrcoef(normal[lag:], normal[:-lag])[0, 1]) < bound
        assert abs(np.corrcoef(uniform[lag:], uniform[:-lag])[0, 1]) < bound
    assert abs(np.corrcoef(normal, uniform)[0, 1]) < bound
    for seed in (0, 12345):
        for lag in range(5):
            other = sequence(seed)[0]
            assert abs(np.corrcoef(normal[lag:], other[: N - lag])[0, 1]) < bound

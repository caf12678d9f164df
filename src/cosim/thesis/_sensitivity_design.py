"""Which settings are run: each open choice alone, a few together, and a fraction of all combinations of two levels.

Changed alone, each choice shows what it does to the assumed setting, over more than two levels; together, in an
orthogonal two-level fraction, what it does whatever the others are, and which of them act upon each other. Every
setting is run at all five sampling times, with and without a hand on the load (G. Taguchi's crossed arrays), as the
conclusion to be tested is one about sampling times: how each choice acts on their differences is then free of any
confounding with them.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.thesis._sensitivity_factors import ASSUMED, FACTORS, SLOW, Level, Setting

BASE = 6
"""Columns of the fraction that are a full factorial: 2^6 settings."""
GENERATORS = ((2, 3, 4), (0, 1, 2, 3), (0, 1, 5), (1, 3, 4, 5), (0, 3, 4, 5))
"""Columns that are products of those, numbered from 0: the 2^(11-5) fraction of resolution IV of the NIST/SEMATECH
e-Handbook of Statistical Methods, 5.3.3.4.7. Main effects are free of two-factor interactions, and all interactions of
the eighth column, which the rate of the chart has, are free of each other and of all others."""


@dataclass(frozen=True)
class Case:
    """A setting under the name that tables and pictures give it; ``design`` is "alone", "together" or "factorial"."""

    name: str
    design: str
    setting: Setting


def signs() -> NDArray[np.int64]:
    """Return the fraction as -1 (low) and 1 (high), shape (64, 11), one column for each of `FACTORS`."""
    full = np.array(list(itertools.product((-1, 1), repeat=BASE)), dtype=np.int64)
    return np.column_stack([full, *(full[:, list(columns)].prod(axis=1) for columns in GENERATORS)])


def interactions() -> dict[tuple[int, int], Sequence[tuple[int, int]]]:
    """Return for each pair of columns those pairs that have the same product, itself among them."""
    matrix = signs()
    pairs = list(itertools.combinations(range(matrix.shape[1]), 2))
    product = {pair: (matrix[:, pair[0]] * matrix[:, pair[1]]).tobytes() for pair in pairs}
    return {pair: [other for other in pairs if product[other] == product[pair]] for pair in pairs}


def alone() -> list[Case]:
    """The setting of the scenarios, then each other level of each choice."""
    cases = [Case("as in the scenarios", "alone", ASSUMED)]
    for factor in FACTORS:
        for level in factor.others:
            cases.append(Case(f"{factor.label}: {factor.format(level)}", "alone", _changed({factor.key: level})))
    return cases


def together() -> list[Case]:
    """Choices that belong together: all of the unit at one rate, and what a latch and a whole ramp make of it."""
    rates: dict[str, Level] = {"chart": SLOW, "measuring": SLOW}
    named: dict[str, dict[str, Level]] = {
        "one rate": rates,
        "one rate, contact sampled": rates | {"park": "sampled"},
        "one rate, Soft_stop a ramp": rates | {"soft_stop": 1.0},
        "one rate, Soft_stop a ramp, noise 0.2 A": rates | {"soft_stop": 1.0, "noise_A": 0.2},
    }
    return [Case(name, "together", _changed(levels)) for name, levels in named.items()]


def factorial() -> list[Case]:
    """The fraction: 64 settings of low and high levels."""
    cases = []
    for number, line in enumerate(signs().tolist(), 1):
        levels = {f.key: f.high if sign > 0 else f.low for f, sign in zip(FACTORS, line, strict=True)}
        cases.append(Case(f"{number}", "factorial", levels))
    return cases


def _changed(levels: dict[str, Level]) -> Setting:
    return {**ASSUMED, **levels}

"""What each open choice does to a response, from the 64 settings of the factorial."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.thesis._sensitivity_design import BASE, interactions, signs

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Effects:
    """Effects on one response, in its unit: the mean at the high level less that at the low one.

    ``main`` has one for each factor, shape (11,); ``pairs`` those of two factors upon each other that are free of other
    such interactions, by the factors' numbers; ``share`` is each factor's part of the response's variation, by itself
    and in these pairs, ``main_share`` by itself. ``margin`` is what effects of no consequence stay below.
    """

    main: Array
    pairs: dict[tuple[int, int], float]
    share: Array
    main_share: Array
    margin: float


def effects(response: Sequence[float] | Array) -> Effects:
    """Estimate the effects on a response of shape (64,), in the order of the factorial."""
    y, matrix = np.asarray(response, dtype=np.float64), signs()
    half = len(y) / 2
    main = matrix.T @ y / half
    clear = [pair for pair, same in interactions().items() if len(same) == 1]
    pairs = {(a, b): float((matrix[:, a] * matrix[:, b]) @ y / half) for a, b in clear}
    # the sum of squares of an effect e is n (e/2)^2
    variation = float(((y - y.mean()) ** 2).sum())
    part = half / (2 * variation) if variation > 0 else 0.0
    main_share = part * main**2
    share = main_share.copy()
    for pair, effect in pairs.items():
        share[list(pair)] += part * effect**2
    return Effects(main, pairs, share, main_share, _margin(y))


def _margin(y: Array) -> float:
    """Return R. V. Lenth's margin of error, 95 % (Technometrics 31 (1989) 469-473), from all 63 contrasts.

    Most of them are small; what they scatter by, t(0.975, 63/3) times, is what no effect needs for an explanation.
    """
    from scipy.stats import t

    full = np.array(list(itertools.product((-1, 1), repeat=BASE)), dtype=np.int64)
    chosen = [c for n in range(1, BASE + 1) for c in itertools.combinations(range(BASE), n)]
    contrasts = np.abs([full[:, list(columns)].prod(axis=1) @ y / (len(y) / 2) for columns in chosen])
    start = 1.5 * np.median(contrasts)
    small = contrasts[contrasts < 2.5 * start]
    return float(t.ppf(0.975, len(chosen) / 3) * 1.5 * np.median(small)) if len(small) else 0.0

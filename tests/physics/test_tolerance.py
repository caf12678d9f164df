"""A tighter tolerance gives a better result, in proportion."""

from __future__ import annotations

import numpy as np

from physics.conftest import Simulate


def test_tightening_by_a_hundred_changes_less_than_the_tolerance_promises(simulate: Simulate) -> None:
    names = ("phi_crank", "i_motor", "tau_crank")
    runs = {tol: simulate("linkage", names, 6.0, 1e-2, tol, (("duty", 1.0),)) for tol in (1e-4, 1e-6, 1e-8, 1e-10)}
    for coarse, fine in ((1e-4, 1e-6), (1e-6, 1e-8), (1e-8, 1e-10)):
        for name in names:
            size = np.abs(runs[1e-10][name]).max()
            change = np.abs(runs[coarse][name] - runs[fine][name]).max()
            assert change < coarse * size, (name, coarse, change)

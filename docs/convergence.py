"""Draws docs/pictures/convergence.png: how the error of the compiled linkage plant follows the tolerance.

Run with ``python docs/convergence.py`` from a checkout with the ``test`` extra installed. The reference is the
independent model of ``tests/reference``, integrated by SciPy to 1e-12.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
from fmpy import simulate_fmu

from cosim.fmu import catalogue

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from reference.plant import linkage_plant  # noqa: E402
from reference.simulation import simulate as reference  # noqa: E402

TOLERANCES = [10.0**-k for k in range(3, 12)]
VARIABLES = {
    "phi_crank": ("crank angle [rad]", "#0072B2", "o"),
    "i_motor": ("motor current [A]", "#D55E00", "s"),
    "tau_crank": ("crank torque [N.m]", "#009E73", "^"),
}


def main() -> None:
    """Simulate, compare, print the errors and draw."""
    mpl.use("Agg")
    import matplotlib.pyplot as plt

    errors: dict[str, list[float]] = {name: [] for name in VARIABLES}
    steps: list[int] = []
    expected = None
    for tolerance in TOLERANCES:
        run = simulate_fmu(
            str(catalogue.ensure("linkage")),
            stop_time=6.0,
            output_interval=1e-3,
            relative_tolerance=tolerance,
            start_values={"duty": 1.0},
            output=[*VARIABLES, "solver.steps"],
        )
        if expected is None:
            expected = reference(linkage_plant(), 1.0, run["time"], rtol=1e-12)
        for name in VARIABLES:
            errors[name].append(float(np.abs(run[name] - expected[name]).max()))
        steps.append(int(run["solver.steps"][-1]))
        print(f"{tolerance:.0e}  {steps[-1]:6d} steps  " + "  ".join(f"{n} {errors[n][-1]:.1e}" for n in VARIABLES))
    figure, axes = plt.subplots(figsize=(7.5, 4.8), layout="constrained")
    for name, (label, colour, marker) in VARIABLES.items():
        axes.loglog(TOLERANCES, errors[name], color=colour, marker=marker, label=label)
    axes.loglog(TOLERANCES, TOLERANCES, color="0.5", linestyle="--", label="error = tolerance")
    for tolerance, count, error in zip(TOLERANCES, steps, errors["phi_crank"], strict=True):
        axes.annotate(
            f"{count} steps", (tolerance, error), (0, -14), textcoords="offset points", ha="center", fontsize=7
        )
    axes.invert_xaxis()
    axes.set_xlabel("relative tolerance")
    axes.set_ylabel("largest error over 6 s of full voltage")
    axes.set_title("Linkage plant against the independent reference", loc="left", fontweight="bold")
    axes.grid(alpha=0.3)
    axes.legend(frameon=False)
    figure.savefig(ROOT / "docs" / "pictures" / "convergence.png", dpi=130)


if __name__ == "__main__":
    main()

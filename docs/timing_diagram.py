"""Draws docs/pictures/timing.png: when a sample is taken and when it acts, without delay and with that of Jacobi.

Run with ``python docs/timing_diagram.py`` from a checkout. The curves are runs of the test FMUs: der(x) = u in the
plant, u = -0.6 x / T at each sample in the controller.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import ConnectionPatch

from cosim.engine import Algorithm, Component, Connection, Fmu, Result, System, simulate

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "benchmarks" / "_peers"))

from peer_fmus import INTEGRATOR, SAMPLER, build  # noqa: E402

T = 0.125
STEPS = 6
PLANT, SAMPLE, ACTION = "#0072B2", "#000000", "#D55E00"


def main() -> None:
    """Run both algorithms and draw them side by side."""
    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, 2, figsize=(10, 5.6), sharex=True, sharey="row", layout="constrained")
    with tempfile.TemporaryDirectory() as folder:
        plant, controller = (Fmu.read(build(model, 3, Path(folder))) for model in (INTEGRATOR, SAMPLER))
        draw(axes[:, 0], run(plant, controller, "gauss-seidel"), 0, "cosim by default: acts from its own instant on")
        draw(axes[:, 1], run(plant, controller, "jacobi"), 1, "exchange, then step (Jacobi): acts one step late")
    axes[0, 0].set_ylabel("plant: x")
    axes[1, 0].set_ylabel("controller to plant: u")
    figure.savefig(ROOT / "docs" / "pictures" / "timing.png", dpi=130)


def run(plant: Fmu, controller: Fmu, algorithm: Algorithm) -> Result:
    """Simulate the loop with a macro step of T."""
    system = System(
        [
            Component("plant", plant, {"x0": 1.0}),
            Component("controller", controller, {"T_compute": T, "K": -0.6 / T}),
        ],
        [Connection(("plant", "x"), ("controller", "u")), Connection(("controller", "y"), ("plant", "u"))],
    )
    return simulate(
        system,
        stop=STEPS * T,
        output_interval=T,
        tolerance=1e-6,
        algorithm=algorithm,
        step=T if algorithm == "jacobi" else None,
    )


def draw(axes: np.ndarray[tuple[int], np.dtype[np.object_]], result: Result, delay: int, title: str) -> None:
    """Draw the plant's state with the samples above, what acts on the plant below, and which leads to which."""
    upper: Axes = axes[0]
    lower: Axes = axes[1]
    k = result.time / T
    x, u = result.columns["plant.x"], result.columns["controller.y"]
    upper.plot(k, x, color=PLANT, linewidth=2, label="x of the plant")
    upper.plot(k[:-1], x[:-1], "o", color=SAMPLE, markersize=7, label="sample: what the controller sees")
    lower.step(k, u, where="post", color=ACTION, linewidth=2, label="u that acts on the plant")
    for n in range(STEPS - delay):
        at = n + delay
        arrow = ConnectionPatch(
            (n, x[n]),
            (at, u[at]),
            "data",
            "data",
            axesA=upper,
            axesB=lower,
            arrowstyle="-|>",
            color="0.35",
            linewidth=1.1,
        )
        arrow.set_linestyle(":" if delay else "-")
        upper.figure.add_artist(arrow)
    for axis in (upper, lower):
        axis.grid(axis="x", color="0.85")
        axis.axhline(0.0, color="0.7", linewidth=0.8)
        axis.spines[["top", "right"]].set_visible(False)
        axis.set_xticks(range(STEPS + 1))
    upper.set_title(title, loc="left", fontsize=11, fontweight="bold")
    upper.legend(frameon=False, loc="upper right", fontsize=9)
    lower.legend(frameon=False, loc="lower right", fontsize=9)
    lower.set_xlabel("time in macro steps T")


if __name__ == "__main__":
    main()

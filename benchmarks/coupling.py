"""Error against cost of continuous coupling: the algorithms here, and other systems, on plants cut into two FMUs.

    python benchmarks/coupling.py            prints a table and draws docs/pictures/coupling.png
    python benchmarks/coupling.py --quick    fewer steps and one round, no picture

The plants are those of tests/engine/coupled_systems.py, as FMI 2.0: two masses on springs (motion to force, force to
motion) and a motor (electrical, mechanical). The error is the largest one of a connected signal over 10 s, relative to
its range, against the exact solution; rows are 0.1 s apart. Times are medians of alternating rounds, without loading
and initialisation; those of fmpy are differences of two runs, and good to about a millisecond. Peers as in
benchmarks/peers.py; one that is missing, or refuses, is reported and left out.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np

sys.path.insert(0, str(Path(__file__).parent / "_peers"))
sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "engine"))

from coupled_systems import COUPLED, Array, CoupledSystems, exact
from peer_session import PEERS, Peer, PeerError, Session

from cosim.engine import simulate

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SYSTEMS = {"oscillator": "two masses, cut at the force", "motor": "motor, electrical and mechanical"}
STOP, INTERVAL = 10.0, 0.1
STEPS = [0.1, 0.05, 0.025, 0.0125, 0.00625, 0.003125, 0.0015625]
TOLERANCES = [10.0**-k for k in range(2, 9)]
FMU_TOLERANCE = 1e-9
"""Relative tolerance of the solvers in the FMUs where it is not what is varied."""
LEAST_TIME = 1e-3
"""Times of fmpy below this [s] are noise: they are differences of two runs."""
PICTURE = Path(__file__).parents[1] / "docs" / "pictures" / "coupling.png"


@dataclass(frozen=True)
class Method:
    """A way to run a system: ``options`` makes the arguments of ``simulate`` from a step [s] or a tolerance."""

    name: str
    colour: str
    marker: str
    settings: list[float]
    options: Callable[[float], dict[str, Any]]


def stepped(algorithm: str, **other: object) -> Callable[[float], dict[str, Any]]:
    """Return what gives the arguments for an algorithm in steps of one length."""
    return lambda step: {"algorithm": algorithm, "step": step, "tolerance": FMU_TOLERANCE, **other}


# colours of Okabe and Ito, which colour-blind people tell apart; markers for those who print in grey
OURS = (
    Method("jacobi", "#999999", "s", STEPS, stepped("jacobi")),
    Method("gauss-seidel", "#000000", "D", STEPS, stepped("gauss-seidel")),
    Method("extrapolated, order 1", "#E69F00", "^", STEPS, stepped("extrapolated", extrapolation=1)),
    Method("extrapolated, order 2", "#CC79A7", "v", STEPS, stepped("extrapolated", extrapolation=2)),
    Method("iterated", "#009E73", "P", STEPS, stepped("iterated")),
    Method("adaptive", "#0072B2", "o", TOLERANCES, lambda tolerance: {"algorithm": "adaptive", "tolerance": tolerance}),
)
OTHERS = {
    peer.name: (peer, marker)
    for peer, marker in zip(
        (
            PEERS[4],
            PEERS[5],
            PEERS[2],
            PEERS[1],
            PEERS[7],
            Peer("CoFmuPy, gauss-seidel", "cofmu", "gauss-seidel", "cofmupy", "cofmupy"),
        ),
        "x+*^12",
        strict=True,
    )
}


BESIDE = {
    "CoFmuPy, jacobi": ("right", 4),
    "CoFmuPy, gauss-seidel": ("left", 0),
    "fmpy, SSP": ("left", 0),
    "libcosim": ("left", 0),
    "ecos": ("left", 0),
}
"""Peers whose curves have their names beside them: which side of the name, and how much higher [points]."""


@dataclass
class Point:
    """One setting of one method: the error, what it cost, and the times of its runs [s]."""

    setting: float
    error: float = np.nan
    do_steps: int = 0
    rollbacks: int = 0
    seconds: list[float] = field(default_factory=list)

    @property
    def time(self) -> float:
        """The median time of a run [s]."""
        return statistics.median(self.seconds)


Curves = dict[str, list[Point]]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--rounds", type=int, default=5)
    chosen = parser.parse_args()
    found: dict[str, Curves] = {}
    with tempfile.TemporaryDirectory() as name:
        systems = CoupledSystems(Path(name))
        for system in SYSTEMS:
            found[system] = measure(systems, system, Path(name), 1 if chosen.quick else chosen.rounds, chosen.quick)
            report(system, found[system])
        systems.close()
    shares(found)
    if not chosen.quick:
        draw(found)
        print(f"\n{PICTURE}")


def measure(systems: CoupledSystems, name: str, folder: Path, rounds: int, quick: bool) -> Curves:
    """Run every method with every setting, in alternating rounds."""
    every = 3 if quick else 1
    curves: Curves = {method.name: [Point(s) for s in method.settings[::every]] for method in OURS}
    sessions = start_peers()
    curves |= {peer: [Point(step) for step in STEPS[::every]] for peer in sessions}
    for _ in range(rounds):
        for method in OURS:
            for point in curves[method.name]:
                run_here(systems, name, method, point)
        for peer in list(sessions):
            try:
                for point in curves[peer]:
                    run_peer(sessions[peer], systems, name, folder, point)
            except PeerError as error:
                print(f"{peer}: left out: {error}")
                sessions.pop(peer).__exit__(None, None, None)
                del curves[peer]
    for session in sessions.values():
        session.__exit__(None, None, None)
    return curves


def start_peers() -> dict[str, Session]:
    sessions: dict[str, Session] = {}
    for name, (peer, _) in OTHERS.items():
        try:
            sessions[name] = Session(peer)
        except PeerError as error:
            print(f"{name}: left out: {error}")
    return sessions


def run_here(systems: CoupledSystems, name: str, method: Method, point: Point) -> None:
    result = simulate(
        systems.system(name, 2),
        stop=STOP,
        output_interval=INTERVAL,
        coupling_error=False,
        **method.options(point.setting),
    )
    point.error = error_of(name, result.time, {n: column.astype(float) for n, column in result.columns.items()}, 0.0)
    account: Any = result.statistics
    point.do_steps = sum(account["steps"].values())
    point.rollbacks = sum(account.get("algorithm", {}).get(kind, 0) for kind in ("rejected", "repeated"))
    point.seconds.append(account["wall_s"])


def run_peer(session: Session, systems: CoupledSystems, name: str, folder: Path, point: Point) -> None:
    coupled = COUPLED[name]
    own = folder / f"{session.peer.script}_{session.peer.variant}_{name}_{point.setting:g}".replace(" ", "_")
    own.mkdir(exist_ok=True)
    answer = session.run(
        {
            "parts": [
                {"name": part, "path": str(systems.fmu(model, 2).path), "parameters": starts(session, part)}
                for part, model in coupled.parts.items()
            ],
            "connections": [[*a.split("."), *b.split(".")] for a, b in coupled.connections],
            "outputs": [column.split(".") for column in coupled.columns],
            "step": point.setting,
            "stop": STOP,
            "every": round(INTERVAL / point.setting),
            "folder": str(own),
            "variant": session.peer.variant,
        }
    )
    columns = {column: np.array(values) for column, values in answer["rows"].items()}
    time = columns.pop("time")
    # some label a row with the beginning of the step that leads to it: the label that fits best counts
    point.error = min(error_of(name, time, columns, shift) for shift in (0.0, point.setting))
    point.do_steps = 2 * round(STOP / point.setting)
    point.seconds.append(answer["seconds"])


def starts(session: Session, part: str) -> dict[str, float]:
    """Return start values of inputs: CoFmuPy sets those to 0 that nothing drives."""
    return {"u": 1.0} if session.peer.script == "cofmu" and part == "winding" else {}


def error_of(name: str, time: Array, columns: Mapping[str, Array], shift: float) -> float:
    """Return the largest error of a connected signal relative to its range, rows being ``shift`` [s] later."""
    whole = exact(name, np.arange(0.0, STOP + 0.5 * INTERVAL, INTERVAL))
    wanted = exact(name, np.maximum(time + shift, 0.0))
    sources = {source for source, _ in COUPLED[name].connections}
    return max(float(np.max(np.abs(columns[s] - wanted[s])) / np.ptp(whole[s])) for s in sources)


def report(system: str, curves: Curves) -> None:
    print(f"\n{SYSTEMS[system]}, {STOP:g} s\n{'':26}{'step':>10}{'error':>10}{'doSteps':>9}{'rollbacks':>10}{'ms':>9}")
    for name, points in curves.items():
        for point in points:
            cost = f"{point.do_steps:9}{point.rollbacks:10}{point.time * 1e3:9.3f}"
            print(f"{name:26}{point.setting:10.3g}{point.error:10.1e}{cost}")


def shares(found: dict[str, Curves]) -> None:
    """Print how many calls of doStep each method needs for an error, relative to the adaptive one."""
    print("\ncalls of doStep (ms) at the same error")
    for system, curves in found.items():
        for error in (1e-2, 1e-3, 1e-4, 1e-6):
            costs = {name: at_error(points, error) for name, points in curves.items()}
            texts = [f"{name} {steps:.0f} ({ms:.2g})" for name, (steps, ms) in costs.items() if steps]
            print(f"{system} {error:.0e}: {', '.join(texts)}")


def at_error(points: list[Point], error: float) -> tuple[float, float]:
    """Return calls of doStep and time [ms] at an error, interpolated between two settings; 0 outside of them."""
    for a, b in pairwise(points):
        if a.error >= error >= b.error:
            part = np.log(a.error / error) / np.log(a.error / b.error)
            steps, ms = (
                float(np.exp((1.0 - part) * np.log(max(x, 1e-9)) + part * np.log(max(y, 1e-9))))
                for x, y in ((a.do_steps, b.do_steps), (a.time * 1e3, b.time * 1e3))
            )
            return steps, ms
    return 0.0, 0.0


def draw(found: dict[str, Curves]) -> None:
    """A row of panels over calls of doStep, one over time; a column for each system."""
    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, len(found), figsize=(11.0, 10.0), layout="constrained", sharex="col")
    costs: list[tuple[str, Callable[[Point], float]]] = [
        ("calls of doStep", lambda point: point.do_steps),
        ("time [ms]", lambda point: point.time * 1e3),
    ]
    for row, (label, cost) in enumerate(costs):
        for column, (system, curves) in enumerate(found.items()):
            axis = axes[row][column]
            for method in OURS:
                plot(axis, curves[method.name], cost, method.name, method.colour, method.marker, 1.8)
            for peer, (_, marker) in OTHERS.items():
                if peer in curves:
                    least = LEAST_TIME if row == 1 and peer.startswith("fmpy") else 0.0
                    points = [point for point in curves[peer] if point.time > least]
                    plot(axis, points, cost, peer, "#D55E00", marker, 0.8 * row)
                    if row == 1 and peer in BESIDE and points:
                        side, up = BESIDE[peer]
                        axis.annotate(
                            peer,
                            (points[-1].error, cost(points[-1])),
                            (6 if side == "left" else -6, up),
                            textcoords="offset points",
                            ha=side,
                            va="center",
                            fontsize=8,
                            color="#D55E00",
                        )
            axis.set_title(SYSTEMS[system] if row == 0 else "", loc="left", fontsize=11, fontweight="bold")
            axis.grid(alpha=0.3)
            axis.set_ylabel(label if column == 0 else "")
            axis.set_xlabel("largest error, relative to the signal's range" if row == 1 else "")
    for axis in axes[0]:
        axis.invert_xaxis()
    handles, labels = axes[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=4, frameon=False, fontsize=9)
    figure.savefig(PICTURE, dpi=110)


def plot(
    axis: Axes, points: list[Point], cost: Callable[[Point], float], label: str, colour: str, marker: str, width: float
) -> None:
    shown = [point for point in points if point.error < 1.0]
    axis.loglog(
        [point.error for point in shown],
        [cost(point) for point in shown],
        color=colour,
        marker=marker,
        markersize=5 if width > 1.0 else 7,
        linewidth=width,
        linestyle="-" if width > 0.0 else "none",
        zorder=2 if width > 1.0 else 3,
        label=label,
    )


if __name__ == "__main__":
    main()

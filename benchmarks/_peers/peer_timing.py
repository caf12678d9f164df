"""When things happen in a peer: the delays of the two connections of a sampled loop, and what result rows show.

The sampler computes y = x at each of its steps and keeps the time of that step, the integrator's state grows by T y per
macro step T, and it counts its steps. All values are exact in binary and all different, so that each value that is
recorded tells when it was computed.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from _worker import Job
from peer_fmus import INTEGRATOR, SAMPLER, build
from peer_session import Peer, Session

T = 0.125
STEPS = 8


@dataclass(frozen=True)
class Timing:
    """Delays and labels in macro steps.

    ``to_controller``: the time of a sample minus the time of the plant's output that it saw; negative if it saw an
    output of the future. ``to_plant``: the time from which a sample acts on the plant minus the time of the sample.
    ``plant_label`` and ``controller_label``: the time written into a row minus the time of the plant's state and of
    the sample in it. ``first_sees_plant``: whether the first sample sees the plant's initial output or else the start
    value of the input.
    """

    to_controller: int
    to_plant: int
    plant_label: int
    controller_label: int
    first_sees_plant: bool


def measure(peer: Peer, fmi: int, folder: Path, *, controller_first: bool = False) -> tuple[Timing, dict[str, str]]:
    """Return the timing of a peer and its versions; raises PeerError."""
    parts = [
        {"name": "plant", "path": str(build(INTEGRATOR, fmi, folder)), "parameters": {"x0": 1.0}},
        {"name": "controller", "path": str(build(SAMPLER, fmi, folder)), "parameters": {"T_compute": T, "K": 1.0}},
    ]
    if controller_first:
        parts.reverse()
    job: Job = {
        "parts": parts,
        "connections": [["plant", "x", "controller", "u"], ["controller", "y", "plant", "u"]],
        "outputs": [["plant", "x"], ["plant", "steps"], ["controller", "y"], ["controller", "t_sample"]],
        "step": T,
        "stop": STEPS * T,
        "every": 1,
        "folder": str(folder),
        "variant": peer.variant,
    }
    with Session(peer) as session:
        rows = session.run(job)["rows"]
        return evaluate(rows), session.versions


def evaluate(rows: dict[str, list[float]]) -> Timing:
    """Return the timing that the rows of a run show."""
    labels = [round(time / T) for time in rows["time"]]
    steps = [round(count) for count in rows["plant.steps"]]
    samples = [round(time / T) for time in rows["controller.t_sample"]]
    x = dict(zip(steps, rows["plant.x"], strict=True))
    y = {k: value for k, value in zip(samples, rows["controller.y"], strict=True) if k >= 0}
    late = range(3, STEPS)  # before, states may be equal to each other
    to_controller = {k - n for k in late for n in late if k in y and n in x and x[n] == y[k]}
    slopes = {n: (x[n + 1] - x[n]) / T for n in late if n in x and n + 1 in x}
    to_plant = {n - k for n, slope in slopes.items() for k in late if k in y and slope == y[k]}
    known = [i for i, k in enumerate(samples) if k >= 0]
    return Timing(
        _only(to_controller),
        _only(to_plant),
        _only({label - n for label, n in zip(labels, steps, strict=True)}),
        _only({labels[i] - samples[i] for i in known}),
        y[0] == x[min(x)],
    )


def _only(found: set[int]) -> int:
    if len(found) != 1:
        raise ValueError(f"the delay is not one number but {sorted(found)}")
    return found.pop()

"""Compares this project's engine with the systems that users could pick instead, on one pair of FMUs.

    python benchmarks/peers.py --install     creates an environment for each group of peers (once)
    python benchmarks/peers.py               cost per macro step, in alternating rounds, and agreement of trajectories
    python benchmarks/peers.py --timing      when things happen: the table of docs/timing.md

Each peer runs in a process of its own, in its own environment; COSIM_PEERS chooses the folder of the environments.
A peer that is not installed, or fails, is reported and left out. Nothing is asserted. See benchmarks/README.md.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_peers"))

from _worker import Job
from peer_fmus import MOTOR, REGULATOR, build
from peer_session import OURS, PEERS, Peer, PeerError, Session, install
from peer_timing import measure

from cosim.fmu import export

DRIVE = Path(__file__).parent / "_peers" / "Drive.mo"
PAIRS = {"c": "C", "modelica": "Modelica"}
STOP = 25.0
INTERVAL = 0.01
FLOOR = Peer("floor: the two doSteps in a C loop", "ours", "floor", "", "cosim")
RING = Peer("the least C loop that exchanges, no rows", "ours", "ring", "", "cosim")
HERE = OURS[1]
REFERENCES = (
    Peer("1 step of delay", "fmpy_loop"),
    Peer("1 step of delay, start values in the first", "fmpy_loop", "start values"),
    Peer("no delay", "fmpy_loop", "delay 0"),
    Peer("2 steps of delay", "fmpy_loop", "delay 2"),
    Peer("plant stepped first", "fmpy_loop", "plant first"),
)
COMPARED = (
    FLOOR,
    HERE,
    RING,
    Peer("cosim, jacobi, last row only", "ours", "end only", "", "cosim"),
    PEERS[2],
    Peer("fmpy container, one doStep, last row only", "fmpy_container", "one doStep", module="fmpy.container_fmu"),
    PEERS[3],
    Peer(
        "fmu-manipulation-toolbox container, likewise",
        "fmutool_container",
        "one doStep",
        module="fmu_manipulation_toolbox",
    ),
    *PEERS[4:6],
    PEERS[0],
    PEERS[1],
    *PEERS[6:],
)
SLOW = 2.0
"""A peer that takes longer than this [s] for one run is run in the first rounds only."""
Rows = dict[str, list[float]]


@dataclass
class Entry:
    """A peer in the comparison: its runs [s], its rows, and why it dropped out."""

    peer: Peer
    session: Session | None = None
    start_s: float = 0.0
    seconds: list[float] = field(default_factory=list)
    rows: Rows = field(default_factory=dict)
    failure: str = ""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--install", action="store_true")
    parser.add_argument("--timing", action="store_true")
    parser.add_argument("--rounds", type=int, default=11)
    parser.add_argument("--pair", choices=PAIRS, default="c", help="where the two FMUs come from")
    parser.add_argument("--step", type=float, nargs="*", default=[1e-3, 1e-4], help="macro steps [s]")
    parser.add_argument("--only", help="compare only peers whose name contains this, and the floor")
    chosen = parser.parse_args()
    if chosen.install:
        install()
    elif chosen.timing:
        timing_table()
    else:
        for step in chosen.step:
            peers = [peer for peer in COMPARED if peer in COMPARED[:4] or (chosen.only or "") in peer.name]
            compare(chosen.pair, peers, step, chosen.rounds)


def build_pair(pair: str, folder: Path) -> tuple[Path, Path]:
    """Return motor and controller, FMI 2.0, exported from Modelica by this project or compiled from C."""
    if pair == "c":
        return build(MOTOR, 2, folder), build(REGULATOR, 2, folder)
    motor, regulator = (export(DRIVE, f"Drive.{name}", folder, fmi="2.0") for name in ("Motor", "Regulator"))
    return motor.rename(folder / "motor2.fmu"), regulator.rename(folder / "regulator2.fmu")


def compare(pair: str, peers: Sequence[Peer], step: float, rounds: int) -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        fmus = build_pair(pair, folder)
        entries = [start(peer, make_job(fmus, folder, peer, step, INTERVAL)) for peer in peers]
        jobs = {entry.peer: make_job(fmus, folder, entry.peer, step, STOP) for entry in entries}
        for number in range(rounds):
            for entry in entries:
                if entry.failure or (number >= 3 and max(entry.seconds) > SLOW):
                    continue
                run(entry, jobs[entry.peer])
        references: list[Entry] = []
        for peer in REFERENCES:
            reference = start(peer, make_job(fmus, folder, peer, step, INTERVAL))
            run(reference, make_job(fmus, folder, peer, step, STOP))
            references.append(reference)
        report(entries, references, pair, step)
        for entry in (*entries, *references):
            if entry.session:
                entry.session.__exit__(None, None, None)


def make_job(fmus: tuple[Path, Path], folder: Path, peer: Peer, step: float, stop: float) -> Job:
    own = folder / f"{peer.script}_{peer.variant}".replace(" ", "_")
    own.mkdir(exist_ok=True)
    motor, regulator = map(str, fmus)
    return {
        "parts": [
            {"name": "motor", "path": motor, "parameters": {"tau": 0.02}},
            {"name": "regulator", "path": regulator, "parameters": {"Kp": 0.5, "Ki": 5.0}},
        ],
        "connections": [["motor", "w", "regulator", "w"], ["regulator", "u", "motor", "u"]],
        "outputs": [["motor", "w"], ["motor", "i"], ["regulator", "u"]],
        "step": step,
        "stop": stop,
        "every": round(INTERVAL / step),
        "folder": str(own),
        "variant": peer.variant,
    }


def start(peer: Peer, job: Job) -> Entry:
    """Start a peer and let it run to the first row."""
    begun = time.perf_counter()
    entry = Entry(peer)
    try:
        entry.session = Session(peer)
        entry.session.run(job)
    except PeerError as error:
        entry.failure = str(error)
    entry.start_s = time.perf_counter() - begun
    return entry


def run(entry: Entry, job: Job) -> None:
    if entry.session is None or entry.failure:
        return
    try:
        answer = entry.session.run(job)
    except PeerError as error:
        entry.failure = str(error)
    else:
        entry.seconds.append(answer["seconds"])
        entry.rows = answer["rows"]


def report(entries: list[Entry], references: list[Entry], pair: str, step: float) -> None:
    steps = round(STOP / step)
    medians = {e.peer: statistics.median(e.seconds) / steps * 1e6 for e in entries if e.seconds and not e.failure}
    # While its inputs stay the same, an FMU of this project steps beyond the macro step: doSteps alone are no floor.
    floor, ours = medians[FLOOR if pair == "c" else RING], medians[HERE]
    print(f"\npair from {PAIRS[pair]}, macro step {step:g} s, {STOP:g} s, rows every {INTERVAL:g} s; us per macro step")
    heads = f"{'median':>9}{'lowest':>9}{'highest':>9}{'above floor':>13}{'x ours':>8}{'runs':>6}{'start s':>9}"
    print(f"{'':48}{heads}  agrees with")
    for entry in entries:
        name = entry.peer.name
        if entry.failure:
            print(f"{name:48} left out: {entry.failure}")
            continue
        median = medians[entry.peer]
        low, high = (bound / steps * 1e6 for bound in (min(entry.seconds), max(entry.seconds)))
        print(
            f"{name:48}{median:9.4f}{low:9.4f}{high:9.4f}{median - floor:13.4f}{median / ours:8.1f}"
            f"{len(entry.seconds):6}{entry.start_s:9.2f}  {agreement(entry.rows, references)}"
        )
    print(
        "versions:",
        ", ".join(sorted({f"{k} {v}" for e in entries if e.session for k, v in e.session.versions.items()})),
    )


def agreement(rows: Rows, references: list[Entry]) -> str:
    """Tell with which delay in the loop the rows agree, and how they are labelled."""
    if not rows:
        return ""
    found = min((distance(rows, reference.rows), reference.peer.name) for reference in references if reference.rows)
    (difference, shift), delay = found
    label = f", row labels {shift * 1e3:+g} ms" if abs(shift) > 1e-9 else ""
    end = " at the end" if len(rows["time"]) == 1 else ""
    return f"{delay}{label}, to {difference:.0e}{end}"


def distance(rows: Rows, reference: Rows) -> tuple[float, float]:
    """Return the largest difference relative to the range of a column, and the shift of the labels [s]."""
    count = len(rows["time"])
    places = [round((rows["time"][0] + INTERVAL / 4) / INTERVAL) + k for k in range(count)]
    places = [min(place, len(reference["time"]) - 1) for place in places]
    if count == 1:
        places = [len(reference["time"]) - 1]
    worst = 0.0
    for name, expected in reference.items():
        if name != "time":
            span = max(expected) - min(expected)
            worst = max(worst, *(abs(v - expected[p]) / span for v, p in zip(rows[name], places, strict=True)))
    return worst, rows["time"][-1] - reference["time"][places[-1]]


def timing_table() -> None:
    print("| system | FMI | plant to controller | controller to plant | plant row | sample row | first sample sees |")
    print("|---|---|---|---|---|---|---|")
    versions: dict[str, str] = {}
    for peer in (*OURS, *PEERS):
        for fmi in (2, 3):
            for controller_first in (False, True):
                with tempfile.TemporaryDirectory() as folder:
                    name = f"{peer.name}, {'controller' if controller_first else 'plant'} first"
                    try:
                        timing, found = measure(peer, fmi, Path(folder), controller_first=controller_first)
                    except (PeerError, ValueError) as error:
                        print(f"| {name} | {fmi}.0 | {error} |")
                        continue
                versions |= found
                numbers = (timing.to_controller, timing.to_plant, timing.plant_label, timing.controller_label)
                first = "plant's output" if timing.first_sees_plant else "start value"
                print(f"| {name} | {fmi}.0 | {' | '.join(map(str, numbers))} | {first} |")
    print("\n" + ", ".join(f"{name} {number}" for name, number in sorted(versions.items())))


if __name__ == "__main__":
    main()

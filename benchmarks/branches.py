"""What branching from one state costs: 1,000 runs that go on from a checkpoint, beside the branched part alone.

Usage: python benchmarks/branches.py [BRANCHES]

The branched part alone is the time inside the loop for the same seconds of an uninterrupted run. Each kind of branch is
timed as a whole, from the request to the result with its columns; what all share, reading nothing but making instances
and setting their states, is divided among them. Rounds alternate; medians.
"""

from __future__ import annotations

import statistics
import sys
import time
from pathlib import Path

from cosim.engine import Branches, Channel, Checkpoint, System, branches, simulate
from cosim.engine._execution import Job, begin, instantiated, loop_name, simulate_to
from cosim.engine.fmu._calls import Site
from cosim.engine.loop._plan import lay_out
from cosim.engine.loop._record import Record
from cosim.fmu import catalogue
from cosim.scenario import assemble, read

ROOT = Path(__file__).parents[1]
BEGIN, STOP, INTERVAL = 4.0, 20.0, 1e-3
ROUNDS = 20
KINDS = ("unchanged", "another channel", "another inertia")


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    print(f"{count} branches from {BEGIN:g} s, rows every 1 ms; ms for one, and how many times the branched part alone")
    print(f"{'scenario':14}{'seconds':>8}{'alone':>8}{'shared':>8}{''.join(f'{kind:>18}' for kind in KINDS)}")
    for name in ("linkage_20ms", "rig_20ms"):
        scenario = read(ROOT / "scenarios" / f"{name}.csv")
        system = assemble(scenario, catalogue.ensure)
        system.channels.append(Channel(("plant", "tau_disturbance"), [0.0], [0.0]))
        arguments = {"stop": STOP, "output_interval": INTERVAL, "tolerance": scenario.tolerance}
        checkpoint = simulate(system, checkpoint_at=[BEGIN], **arguments).checkpoints[0]
        for seconds in (0.5, 1.0, 2.0, 5.0, 10.0):
            line(name, system, checkpoint, seconds, count)
        for component in system.components:
            component.fmu.close()


def line(name: str, system: System, checkpoint: Checkpoint, seconds: float, count: int) -> None:
    alone: list[float] = []
    times: list[list[float]] = [[] for _ in KINDS]
    opening = time.perf_counter()
    with branches(checkpoint, system) as run:
        shared = (time.perf_counter() - opening) / count
        for _ in range(ROUNDS):
            alone.append(part_of_a_run(system, checkpoint, seconds))
            for kind, found in enumerate(times):
                begun = time.perf_counter()
                for number in range(count // ROUNDS):
                    branch(run, kind, number, BEGIN + seconds)
                found.append((time.perf_counter() - begun) / (count // ROUNDS) + shared)
    least = statistics.median(alone)
    shown = [f"{(t := statistics.median(found)) * 1e3:10.3f}, {t / least:5.2f}x" for found in times]
    print(
        f"{name:14}{seconds:8g}{least * 1e3:8.3f}{shared * 1e3:8.3f}{''.join(f'{text:>18}' for text in shown)}",
        flush=True,
    )


def part_of_a_run(system: System, checkpoint: Checkpoint, seconds: float) -> float:
    """Return the time [s] inside the loop from BEGIN on, in a run from 0."""
    tolerance = float(str(checkpoint.setup.settings["tolerance"]))
    job = Job(system, STOP, INTERVAL, tolerance)
    record = Record.empty(STOP, INTERVAL, lay_out(system).recorded, loop_name())
    with instantiated(job, [Site(record.at, number) for number in range(len(system.components))]) as plan:
        begin(job, plan, record)
        simulate_to(BEGIN, job, plan, record)
        begun = time.perf_counter()
        simulate_to(BEGIN + seconds, job, plan, record)
        return time.perf_counter() - begun


def branch(run: Branches, kind: int, number: int, stop: float) -> None:
    if KINDS[kind] == "unchanged":
        run(stop=stop)
    elif KINDS[kind] == "another channel":
        torque = Channel(("plant", "tau_disturbance"), [BEGIN + 0.1, BEGIN + 0.2], [-1e-3 * number, 0.0])
        run(stop=stop, channels=[torque])
    else:
        run(stop=stop, parameters={("plant", "J_rotor"): 1e-4 + 1e-8 * number})


if __name__ == "__main__":
    main()

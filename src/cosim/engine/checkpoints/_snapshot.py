"""What the engine itself remembers at a communication point, copied from the plan of a run and put back into one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from cosim.engine.loop._plan import Plan
from cosim.engine.loop._record import Record
from cosim.engine.signals._participant import Participant
from cosim.engine.system._memory import Numbers


class Progress(NamedTuple):
    """How far a component has come; the same as in ``Participant``, which is never in Event Mode then."""

    time: float
    due: float
    ticks: int
    steps: int
    events: int
    stale: bool


@dataclass(frozen=True)
class Snapshot:
    """A communication point at ``time`` [s], after its events: the FMUs' own states are not in it.

    ``exchanges`` counts as in ``Record``; ``values`` and ``inputs`` are the doubles of the plan, ``memory`` what else
    it remembers by name, ``texts`` its texts by slot; ``components`` are in the order of the system.
    """

    time: float
    exchanges: int
    values: bytes
    inputs: bytes
    memory: dict[str, bytes]
    texts: dict[int, bytes]
    components: tuple[Progress, ...]


def in_order(plan: Plan) -> Sequence[Participant]:
    """Return the participants in the order of the system's components."""
    return sorted([*plan.discrete, *plan.continuous], key=lambda participant: participant.instance.site.number)


def take(plan: Plan, record: Record) -> Snapshot:
    """Copy everything; the run is to be between two steps."""
    return Snapshot(
        time=record.now,
        exchanges=record.exchanges,
        values=plan.values.tobytes(),
        inputs=plan.inputs.tobytes(),
        memory={name: memory.to_bytes() for name, memory in plan.memory.items()},
        texts=dict(plan.texts),
        components=tuple(Progress(p.time, p.due, p.ticks, p.steps, p.events, p.stale) for p in in_order(plan)),
    )


def put_back(snapshot: Snapshot, plan: Plan, record: Record) -> None:
    """Copy everything back, into a plan of the same system; the record's rows are left as they are.

    Raises ValueError for what cannot be of the same system.
    """
    if snapshot.memory.keys() != plan.memory.keys():
        raise ValueError(f"memory of {', '.join(snapshot.memory)}")
    if not all(plan.first_text <= slot < len(plan.values) for slot in snapshot.texts):
        raise ValueError("texts")
    Numbers(plan.values).from_bytes(snapshot.values)
    Numbers(plan.inputs).from_bytes(snapshot.inputs)
    for name, content in snapshot.memory.items():
        plan.memory[name].from_bytes(content)
    plan.texts.clear()
    plan.texts.update(snapshot.texts)
    for participant, progress in zip(in_order(plan), snapshot.components, strict=True):
        participant.time, participant.due = progress.time, progress.due
        participant.ticks, participant.steps, participant.events = progress.ticks, progress.steps, progress.events
        participant.stale, participant.in_event_mode = progress.stale, False
    plan.schedule.skip(snapshot.time)
    record.now, record.exchanges = snapshot.time, snapshot.exchanges

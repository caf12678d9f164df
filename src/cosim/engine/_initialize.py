"""Initialisation: all components brought to t = 0, their connections fulfilled."""

from __future__ import annotations

from cosim.engine._instance import CallError
from cosim.engine._loop import check_numbers
from cosim.engine._participant import Participant
from cosim.engine._plan import Plan
from cosim.engine._role import Role

_MOST_PASSES = 50


def initialize(plan: Plan, tolerance: float, stop: float | None) -> None:
    """Bring all components to t = 0, their connections fulfilled; ``stop`` [s] is None if the end is not known.

    Only continuous components are told the stop time: one that is sampled at stop must be allowed to step past it.
    """
    participants = [*plan.continuous, *plan.discrete]
    for participant in participants:
        if not participant.instance.initializes_at_once:
            _enter(participant, tolerance, stop)
    for passes in range(_MOST_PASSES):
        before = list(plan.values)
        for participant in participants:
            participant.write(force=passes == 0)
            if passes == 0 and participant.instance.initializes_at_once:
                _enter(participant, tolerance, stop)
            participant.read()
        check_numbers(plan)
        if _agree(before, plan.values.tolist()):
            break
    else:
        raise CallError(
            _unsettled(participants).instance,
            f"inputs and outputs do not agree after {_MOST_PASSES} passes of initialisation",
            "break the algebraic loop between the components",
        )
    for participant in participants:
        participant.instance.exit_initialization()
    for participant in plan.continuous:
        participant.read()


def _enter(participant: Participant, tolerance: float, stop: float | None) -> None:
    continuous = participant.role is Role.CONTINUOUS
    participant.instance.enter_initialization(tolerance, stop if continuous else None)


def _agree(before: list[float], after: list[float]) -> bool:
    return all(abs(a - b) <= 1e-12 * max(abs(a), abs(b)) or a == b for a, b in zip(before, after, strict=True))


def _unsettled(participants: list[Participant]) -> Participant:
    return next(participant for participant in participants if participant.input_groups)

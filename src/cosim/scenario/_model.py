"""What a scenario file says, with the places at which it says it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path

from cosim.engine import Algorithm, FaultKind
from cosim.units import Unit


class ScenarioWarning(UserWarning):
    """Something in a scenario that has no effect, or another one than it may seem."""


@dataclass(frozen=True)
class Setting:
    """A start value for a parameter: ``set: plant.ext_load = 4 N.m``. ``file`` is ``--set`` for an option.

    ``origin`` tells for reports where the value comes from, if not from the scenario or an option.
    """

    name: str
    value: str
    file: Path | str
    line: int | None = None
    origin: str | None = None


@dataclass(frozen=True)
class Link:
    """A connection by hand: ``map: plant.tau_crank -> controller.torque``; both as (component, variable)."""

    source: tuple[str, str]
    target: tuple[str, str]
    line: int | None


@dataclass(frozen=True)
class FaultLine:
    """A fault as a ``fault`` line says it: times in s, ``amount`` as written, with its unit; empty for ``freeze``.

    ``file`` is ``--fault`` for an option. ``every`` and ``seed`` are None where the line has none.
    """

    name: str
    kind: FaultKind
    amount: str
    start: float
    stop: float
    every: float | None
    seed: int | None
    file: Path | str
    line: int | None = None


@dataclass(frozen=True)
class Power:
    """A pair of connections that carry power: ``power: motor.tau * load.w``; both as (component, variable)."""

    effort: tuple[str, str]
    flow: tuple[str, str]
    sign: float
    line: int | None


@dataclass(frozen=True)
class Column:
    """A channel of the table, in its own unit (``None``: the header gives none).

    ``times`` [s], ``values`` and ``lines`` (of the file) have one entry per cell that is not empty. A step is two
    entries with one time. ``position`` is the cell's number in a row, from 1.
    """

    name: str
    unit: Unit | None
    position: int
    line: int
    times: tuple[float, ...]
    values: tuple[float, ...]
    lines: tuple[int, ...]
    linear: bool = False


@dataclass(frozen=True)
class Scenario:
    """A scenario as read: times in s, names not yet resolved. ``key_lines`` tells where a key was written."""

    path: Path
    title: str
    system: str
    controller: str | None
    stop: float
    sample_time: float
    output_interval: float
    tolerance: float
    algorithm: Algorithm = "auto"
    macro_step: float | None = None
    extrapolation: int | None = None
    settings: tuple[Setting, ...] = ()
    links: tuple[Link, ...] = ()
    powers: tuple[Power, ...] = ()
    columns: tuple[Column, ...] = ()
    faults: tuple[FaultLine, ...] = ()
    key_lines: dict[str, int | None] = field(default_factory=dict)


def is_structure(system: str) -> bool:
    """Tell whether a system is an ``.ssp``, one of several structures in it (``x.ssp#Y.ssd``), or an ``.ssd``."""
    return Path(system).suffix.lower() in (".ssp", ".ssd")


def suggestion(name: str, known: Sequence[str]) -> str:
    """Return `, did you mean 'x'?` for a near miss, else an empty text.

    A name without its component counts as near: ``ext_lod`` finds ``plant.ext_load``.
    """
    lowered = {candidate.lower(): candidate for candidate in known}
    lowered |= {candidate.rpartition(".")[2].lower(): candidate for candidate in known if "." not in name}
    near = get_close_matches(name.lower(), list(lowered), n=1, cutoff=0.6)
    return f", did you mean '{lowered[near[0]]}'?" if near else ""

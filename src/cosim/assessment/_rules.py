"""How the criteria of the thesis's section 4.5 are read where the source leaves it open."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

from cosim.errors import InputError


@dataclass(frozen=True)
class Rules:
    """The choices of the scoring; each default is the plainest reading of the source.

    The source looks at plots of ten seconds, on which a tenth of a second is a millimetre; it gives no tolerance.
    """

    span: float = field(default=20.0, metadata={"unit": "s"})
    """Length of what is scored, from the first row on [s]; section 4.5 scores 20 s of runs of about 25 s."""
    early: float = field(default=0.0, metadata={"unit": "s"})
    """Criterion 1: how long before the park signal the deceleration may have ended [s]."""
    late: float = field(default=0.0, metadata={"unit": "s"})
    """Criterion 1: how long after the park signal the deceleration may begin [s].

    With 0 it must have begun before the signal: the profile answers a park signal that it has not predicted with a
    deceleration, too, and that is no prediction.
    """
    position: float = field(default=0.125, metadata={"unit": "1"})
    """Criterion 2: how far from the median of all turns a turn may be, as a share of the revolution.

    "On the same position on the current signal", which repeats once per revolution of the crank. The default is a
    quarter of the half revolution between turn and park; infinity accepts any position.
    """
    repeats: Literal["grouped", "separate"] = "grouped"
    """Criterion 3: whether a repeated state counts in table 4.1, or is only listed.

    The table has a column for criterion 1 and one for criterion 2 and counts "failure to comply to above mentioned
    points". Grouped: a repeated Soft_start or Soft_stop fails the park prediction, a repeated turn_point_dec or
    turn_point_acc the turn prediction.
    """
    unfinished: bool = False
    """Criterion 2: whether the revolution that the span cuts off counts, if it has turned or should have.

    Table 4.1 has up to one turn more than park signals.
    """

    def __post_init__(self) -> None:
        """Check the ranges; raises `InputError`."""
        if not (math.isfinite(self.span) and self.span > 0):
            raise InputError(f"span {self.span} s: the length of what is scored must be positive")
        for name in ("early", "late"):
            if not (math.isfinite(value := getattr(self, name)) and value >= 0):
                raise InputError(f"{name} {value} s: a tolerance of the park prediction must not be negative")
        if not self.position >= 0:
            raise InputError(f"position {self.position}: a share of a revolution from 0 on, or inf for any position")
        if self.repeats not in ("grouped", "separate"):
            raise InputError(f"repeats '{self.repeats}': accepted are grouped and separate")

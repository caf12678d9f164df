"""How a result is compared with a measurement."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

from cosim.comparison._alignment import Alignment
from cosim.errors import InputError
from cosim.measurement import Smoothing

Quantity = Literal["torque", "current", "speed", "voltage"]
TorqueZero = Literal["onset", "line"]

SIGNALS: dict[str, tuple[str, str, str]] = {
    "torque": ("tau_crank", "N.m", "nm"),
    "current": ("i_motor", "A", "a"),
    "speed": ("w_crank", "rad/s", "rad_s"),
    "voltage": ("v_motor", "V", "v"),
}
"""For each quantity: the result's signal, the unit, and how the unit is written in the names of figures."""
OF_THE_QUANTITY = "quantity"
"""In place of the unit of an option: that of the quantity which is compared."""
ALIGNMENTS = ("correlation", "onset", "angle", "none")
TORQUE_ZEROS = ("onset", "line")
SMOOTHINGS = ("none", "moving_average", "zero_phase")


@dataclass(frozen=True)
class Options:
    """What is compared, how it is aligned, and how wide the tube is.

    ``start`` and ``stop`` [s] bound the part of the result that counts; over the crank angle, also that of the
    measurement. "correlation" looks for lags up to ``lag_most`` [s] either way. ``smoothing`` is applied to both
    signals alike. ``torque_zero`` says where a workbook's torque is zero: at its onset, as the source makes it, or
    where its line of current over torque says so. The tube's half width is ``tube_x`` [s], its half height the larger
    of ``tube_y`` (in the quantity's unit) and ``tube_y_relative`` times the range of the measurement.
    """

    quantity: Quantity = "torque"
    align: Alignment = "correlation"
    smoothing: Smoothing = "none"
    torque_zero: TorqueZero = "onset"
    start: float = field(default=0.0, metadata={"unit": "s"})
    stop: float = field(default=math.inf, metadata={"unit": "s"})
    lag_most: float = field(default=5.0, metadata={"unit": "s"})
    tube_x: float = field(default=0.05, metadata={"unit": "s"})
    tube_y: float = field(default=0.0, metadata={"unit": OF_THE_QUANTITY})
    tube_y_relative: float = field(default=0.1, metadata={"unit": "1"})

    def __post_init__(self) -> None:
        """Check the choices; raises `InputError`."""
        for name, known in (
            ("quantity", tuple(SIGNALS)),
            ("align", ALIGNMENTS),
            ("smoothing", SMOOTHINGS),
            ("torque_zero", TORQUE_ZEROS),
        ):
            if getattr(self, name) not in known:
                raise InputError(f"{name}: there is no '{getattr(self, name)}'; accepted are {', '.join(known)}")
        for name in ("lag_most", "tube_x", "tube_y", "tube_y_relative"):
            if not 0.0 <= getattr(self, name) < math.inf:
                raise InputError(f"{name}: {getattr(self, name):g}; a finite number, not negative, is expected")
        if not self.start < self.stop:
            raise InputError(f"the part from {self.start:g} s to {self.stop:g} s has no length")

"""How vibration is measured: lengths and bands, each a choice."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from cosim.errors import InputError

SECONDS = {"unit": "s"}


@dataclass(frozen=True)
class Method:
    """The choices of the vibration measures. The source gives none of them."""

    window: float = field(default=0.01, metadata=SECONDS)
    """A rate is the mean over this long [s]. 10 ms are five electrical time constants, a sixth of the time that the
    motor takes to start, and blind to 100 Hz."""
    start: float = field(default=0.5, metadata=SECONDS)
    """How long the start takes [s], from the first current on: about a quarter of a revolution."""
    around: float = field(default=0.1, metadata=SECONDS)
    """A turning point reaches this far to either side [s]: a ramp of the voltage profile."""
    since: float = field(default=0.0, metadata=SECONDS)
    """What is before is not looked at [s]."""
    until: float = field(default=math.inf, metadata=SECONDS)
    """What is after is not looked at [s]."""
    radius: float = field(default=0.055, metadata={"unit": "m"})
    """Where on the crank its acceleration is taken [m]: at the pin, B.1.2 of the source."""
    bands: tuple[float, ...] = (1.0, 10.0, 100.0)
    """Limits of the frequency bands [Hz]. Below 1 Hz is the wiping itself."""
    lines: int = 5
    """How many lines of the spectrum are told."""

    def __post_init__(self) -> None:
        """Check the ranges; raises `InputError`."""
        for name in ("window", "start", "around", "radius"):
            if not (math.isfinite(value := getattr(self, name)) and value > 0):
                raise InputError(f"{name} {value}: must be positive")
        if not self.until > self.since:
            raise InputError(f"since {self.since} s, until {self.until} s: the first must lie before the second")
        if len(self.bands) < 2 or not all(a < b for a, b in zip(self.bands, self.bands[1:], strict=False)):
            raise InputError(f"bands {self.bands}: give limits that increase, such as (1, 10, 100)")

"""The linear system: matrices with the names and units of what they relate, and its poles."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cosim.errors import InputError

if TYPE_CHECKING:
    import control

Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class Signal:
    """A state, input or output with its value at the operating point; ``unit`` is "1" where the model gives none."""

    name: str
    unit: str
    value: float


@dataclass(frozen=True)
class Pole:
    """An eigenvalue of A [1/s].

    ``frequency`` is its distance from zero [rad/s], ``damping`` the ratio -Re/|.| (1 for a real stable one, negative
    for an unstable one, None at zero), ``time_constant`` -1/Re [s] (None on the imaginary axis, negative if unstable).
    """

    real: float
    imaginary: float
    frequency: float
    damping: float | None
    time_constant: float | None


@dataclass(frozen=True)
class LinearSystem:
    """``dx/dt = slope + A (x - x0) + B (u - u0)``, ``y = y0 + C (x - x0) + D (u - u0)``.

    x, u and y are ``states``, ``inputs`` and ``outputs``; the index 0 marks the values at the operating point, which
    the signals carry. Element [i, j] is in the unit of what row i stands for over the unit of column j.
    """

    model: str
    at: str
    """What was asked for: "initial", "steady" or a time."""
    time: float
    """Simulated time of the operating point [s]."""
    states: tuple[Signal, ...]
    inputs: tuple[Signal, ...]
    outputs: tuple[Signal, ...]
    A: Matrix
    """Shape (states, states)."""
    B: Matrix
    """Shape (states, inputs)."""
    C: Matrix
    """Shape (outputs, states)."""
    D: Matrix
    """Shape (outputs, inputs)."""
    slope: Matrix
    """dx/dt at the operating point, shape (states,): zero in a steady state, but for the states that were excepted."""
    held: dict[str, float] = field(default_factory=dict)
    """Discrete variables that act on the system, and inputs that are no Reals, with the values that they keep."""
    parameters: dict[str, float] = field(default_factory=dict)
    """Parameters that were set, in the model's units."""

    @property
    def poles(self) -> list[Pole]:
        """The eigenvalues of A, the slowest first; of a pair the one above the real axis first."""
        if not self.states:
            return []
        # a rounding error must not decide which of a pair comes first
        values = sorted(np.linalg.eigvals(self.A), key=lambda p: (float(f"{abs(p):.9e}"), p.real, -p.imag))
        return [_pole(complex(value)) for value in values]

    def control(self) -> control.StateSpace:
        """Return the system as a `control.StateSpace` of python-control, with the signals' names.

        Raises:
            InputError: python-control is not installed.
        """
        try:
            import control
        except ImportError:
            raise InputError("this needs python-control; install it with: pip install 'wiper-cosim[control]'") from None
        # python-control takes a dot for the port of a subsystem
        names = {
            kind: [signal.name.replace(".", "_") for signal in signals]
            for kind, signals in (("states", self.states), ("inputs", self.inputs), ("outputs", self.outputs))
        }
        return control.ss(self.A, self.B, self.C, self.D, name=self.model.replace(".", "_"), **names)

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain lists and numbers, for JSON."""
        matrices = {name: getattr(self, name).tolist() for name in ("A", "B", "C", "D", "slope")}
        signals = {name: [asdict(signal) for signal in getattr(self, name)] for name in ("states", "inputs", "outputs")}
        point = {"model": self.model, "at": self.at, "time": self.time}
        rest = {"held": self.held, "parameters": self.parameters, "poles": [asdict(pole) for pole in self.poles]}
        return point | signals | matrices | rest


def per_second(unit: str) -> str:
    """Return the unit of a time derivative: rad/s for rad, m/s2 for m/s, V/(m.s) for V/m."""
    if unit in ("1", "-", ""):
        return "1/s"
    above, slash, below = unit.partition("/")
    if not slash:
        return f"{unit}/s"
    if below == "s" or (below.startswith("s") and below[1:].isdigit()):
        return f"{above}/s{int(below[1:] or 1) + 1}"
    return f"{above}/({below.removeprefix('(').removesuffix(')')}.s)"


def _pole(value: complex) -> Pole:
    size = abs(value)
    return Pole(
        real=value.real,
        imaginary=value.imag,
        frequency=size,
        damping=0.0 - value.real / size if size else None,
        time_constant=-1.0 / value.real if value.real and math.isfinite(1.0 / value.real) else None,
    )

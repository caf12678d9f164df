"""The operating point, found by the model's own FMU: simulated to a time, then everything inside it is read.

For this the FMU gets outputs that others do not have: each state, torn unknown, discrete variable and relation.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cosim.dae import Dae
from cosim.dae.dae import Published
from cosim.dae.hybrid import SX, Scalar
from cosim.engine import Channel, Component, Fmu, System, Value, Variable, simulate
from cosim.errors import InputError
from cosim.fmu.exporter import pack
from cosim.linear._equations import Point, parameter_values
from cosim.scenario import parameter_value

_COMPONENT = "model"
_MOMENT = 1e-6
"""A simulation this long [s] gives the initial point in its first row."""
_TOLERANCE = 1e-9

Given = Mapping[str, float | str]
"""Values by name: numbers in the variable's unit, or texts with a unit."""


@contextmanager
def observed(dae: Dae, kept: Path | None = None) -> Iterator[Observed]:
    """Build the FMU that tells everything of its inside; it exists inside the ``with`` only, unless it is kept.

    Args:
        dae: the model.
        kept: a folder in which the FMU stays for the next time. Its name has to tell what the FMU is made from.

    Raises:
        BuildError: there is no C compiler, or it failed.
    """
    telling, columns = _telling(dae)
    if kept is not None:
        from filelock import FileLock

        kept.mkdir(parents=True, exist_ok=True)
        with FileLock(kept / "lock"):
            path = next(iter(kept.glob("*.fmu")), None) or pack(telling, kept)
        yield Observed(dae, Fmu.read(path), columns)
        return
    with tempfile.TemporaryDirectory(prefix="cosim-linear-") as folder:
        yield Observed(dae, Fmu.read(pack(telling, Path(folder))), columns)


@dataclass(frozen=True)
class Observed:
    """The FMU of a model, and which of its outputs are what inside."""

    dae: Dae
    fmu: Fmu
    columns: dict[str, list[str]]
    """Outputs for the states "x", the torn unknowns "z", the discrete variables "d" and the relations "c"."""

    def parameters(self, given: Given) -> dict[str, Value]:
        """Return the values of parameters in the model's units.

        Raises:
            InputError: there is no such parameter, or the value or its unit does not fit.
        """
        return {name: _value(given[name], name, self._variable(name, "parameter")) for name in given}

    def inputs(self, given: Given) -> dict[str, float]:
        """Return the values of all inputs, those that are not given at their start.

        Raises:
            InputError: there is no such input, or the value or its unit does not fit.
        """
        values = {name: _value(given[name], name, self._variable(name, "input")) for name in given}
        starts = {v.name: v.start for v in self.fmu.variables.values() if v.causality == "input"}
        return {name: float(values.get(name, start) or 0.0) for name, start in starts.items()}

    def at(self, time: float, parameters: dict[str, Value], inputs: dict[str, float]) -> Point:
        """Simulate from 0 to ``time`` [s] with constant inputs; 0 is the initial point.

        Raises:
            SimulationError: the simulation failed before.
        """
        channels = [Channel((_COMPONENT, name), [0.0], [value]) for name, value in inputs.items()]
        system = System([Component(_COMPONENT, self.fmu, dict(parameters))], channels=channels)
        stop = time or _MOMENT
        result = simulate(system, stop=stop, output_interval=stop, tolerance=_TOLERANCE)
        row = -1 if time else 0

        def read(kind: str) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
            return np.array([float(result.columns[f"{_COMPONENT}.{n}"][row]) for n in self.columns[kind]], dtype=float)

        reals = {name: float(value) for name, value in parameters.items() if not isinstance(value, str)}
        return Point(
            time=time,
            x=read("x"),
            z=read("z"),
            u=np.array([inputs[s.name] for s in self.dae.inputs], dtype=float),
            p=parameter_values(self.dae, reals),
            d=read("d"),
            c=read("c"),
        )

    def _variable(self, name: str, kind: str) -> Variable:
        known = [v.name for v in self.fmu.variables.values() if v.causality == kind]
        if name not in known:
            from difflib import get_close_matches

            near = get_close_matches(name, known, n=3)
            hint = f"did you mean {' or '.join(near)}?" if near else f"there are {', '.join(known) or 'none'}"
            raise InputError(f"{self.dae.name} has no {kind} '{name}'; {hint}")
        return self.fmu.variables[name]


def _value(given: float | str, name: str, variable: Variable) -> Value:
    if isinstance(given, str):
        return parameter_value(given, name, variable)
    if not np.isfinite(given):
        raise InputError(f"'{name}' takes a finite number, not {given}")
    match variable.type:
        case "Boolean":
            return bool(given)
        case "Integer" | "Enumeration":
            return int(given)
    return float(given)


def _telling(dae: Dae) -> tuple[Dae, dict[str, list[str]]]:
    """Return the Dae with its inside published as outputs, and their names."""
    inside: dict[str, list[tuple[SX, Scalar | None]]] = {
        "x": [(u.symbol, None) for u in dae.states],
        "z": [(u.symbol, None) for u in dae.torn],
        "d": [(s.symbol, s) for s in dae.discretes],
        "c": [(r.symbol, None) for r in dae.relations],
    }
    prefix = "_"
    while any(p.scalar.name.startswith(prefix) for p in dae.published):
        prefix += "_"
    published = list(dae.published)
    columns: dict[str, list[str]] = {kind: [] for kind in inside}
    for kind, symbols in inside.items():
        for position, (symbol, scalar) in enumerate(symbols, 1):
            name = f"{prefix}{kind}{position}"
            columns[kind].append(name)
            published.append(Published(_output(name, symbol, scalar, dae), symbol))
    return replace(dae, published=published), columns


def _output(name: str, symbol: SX, scalar: Scalar | None, dae: Dae) -> Scalar:
    """A scalar that is published as an output; a discrete variable keeps its type."""
    if scalar is None:
        model = dae.published[0].scalar.declaration
        declaration = replace(
            model, name=name, type="Real", variability="continuous", causality="output", dimensions=(), start=None,
            binding=None, minimum=None, maximum=None, nominal=None, unit=None, display_unit=None, quantity=None,
            description=None, literals=(), protected=False,
        )  # fmt: skip
    else:
        declaration = replace(scalar.declaration, causality="output", protected=False, minimum=None, maximum=None)
    return Scalar(name, declaration, symbol, None, 1.0)

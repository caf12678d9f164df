"""Where each variable of a Dae lives in the FMU: its value reference, its store in the runtime, its FMI attributes."""

from __future__ import annotations

from dataclasses import dataclass, field

from cosim.dae import Dae
from cosim.dae.hybrid import SX, Scalar
from cosim.dae.symbolic import evaluate
from cosim.fmu.tunable import tunable_parameters

COUNTERS = {
    "solver.steps": "Accepted steps of the solver",
    "solver.rejected_steps": "Rejected steps of the solver",
    "solver.rhs_evaluations": "Evaluations of the right-hand side",
    "solver.jacobians": "Evaluations of the Jacobian",
    "solver.state_events": "State events",
    "solver.time_events": "Instants known beforehand, at which a sample clock ticked or a relation of time changed",
}
"""Statistics that every FMU publishes; the order is that of the runtime's ModelCounter."""

_TYPES = {"Real": "TYPE_REAL", "Integer": "TYPE_INTEGER", "Boolean": "TYPE_BOOLEAN", "Enumeration": "TYPE_ENUMERATION"}


@dataclass(frozen=True)
class Slot:
    """One variable of the FMU; the value reference is its position."""

    name: str
    scalar: Scalar | None
    """``None`` for time and for counters."""
    description: str | None
    store: str
    index: int
    type: str
    settable: str
    causality: str
    variability: str
    initial: str | None
    start: float | None


@dataclass
class Layout:
    """All variables of an FMU in the order of their value references, and what the two output stores hold."""

    slots: list[Slot] = field(default_factory=list)
    outputs: list[SX] = field(default_factory=list)
    locals: list[SX] = field(default_factory=list)


def lay_out(dae: Dae) -> Layout:
    """Lay out time, the published variables, and the solver's counters."""
    layout = Layout()
    layout.slots.append(
        Slot(
            "time",
            None,
            "Simulation time",
            "STORE_TIME",
            0,
            "TYPE_REAL",
            "SET_NEVER",
            "independent",
            "continuous",
            None,
            None,
        )
    )
    places = _places(dae)
    parameters = {p.scalar.name: p for p in dae.parameters}
    tunable = tunable_parameters(dae)
    discrete_model = not dae.unknowns
    for published in dae.published:
        scalar, value = published.scalar, published.value
        store, index = places.get(value.name(), ("", 0)) if value.is_symbolic() else ("", 0)
        causality: str = scalar.causality
        variability, settable = "continuous", "SET_NEVER"
        initial: str | None = "calculated"
        start: float | None = None
        if scalar.name in parameters:
            independent = parameters[scalar.name].independent
            causality = "parameter" if independent else "calculatedParameter"
            variability = "tunable" if scalar.name in tunable else "fixed"
            initial = "exact" if independent else "calculated"
            if independent:
                settable = "SET_ALWAYS" if scalar.name in tunable else "SET_BEFORE_INITIALIZATION_ENDS"
            start = dae.parameter_values[scalar.name] if independent else None
        elif causality == "input":
            initial, settable = None, "SET_ALWAYS"
            start = 0.0 if scalar.start is None else float(evaluate(scalar.start, dae.parameter_values))
            variability = "continuous" if scalar.type == "Real" and not discrete_model else "discrete"
        elif scalar.variability == "discrete" or scalar.type != "Real":
            variability = "discrete"
        if not store:
            store, group = ("STORE_OUTPUT", layout.outputs) if causality == "output" else ("STORE_LOCAL", layout.locals)
            index = len(group)
            group.append(value)
        layout.slots.append(
            Slot(
                scalar.name,
                scalar,
                scalar.declaration.description,
                store,
                index,
                _TYPES[scalar.type],
                settable,
                causality,
                variability,
                initial,
                start,
            )
        )
    for index, (name, description) in enumerate(COUNTERS.items()):
        layout.slots.append(
            Slot(
                name,
                None,
                description,
                "STORE_COUNTER",
                index,
                "TYPE_COUNTER",
                "SET_NEVER",
                "local",
                "discrete",
                "calculated",
                None,
            )
        )
    return layout


def _places(dae: Dae) -> dict[str, tuple[str, int]]:
    places: dict[str, tuple[str, int]] = {}
    for store, names in (
        ("STORE_UNKNOWN", [u.symbol.name() for u in dae.unknowns]),
        ("STORE_INPUT", [s.name for s in dae.inputs]),
        ("STORE_PARAMETER", [p.scalar.name for p in dae.parameters]),
        ("STORE_DISCRETE", [s.name for s in dae.discretes]),
    ):
        places |= {name: (store, index) for index, name in enumerate(names)}
    return places

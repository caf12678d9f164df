"""Where each variable of a Dae lives in the FMU: its value reference, its store in the runtime, its FMI attributes."""

from __future__ import annotations

import itertools
import re
from dataclasses import dataclass, field, replace

from cosim.dae import Dae
from cosim.dae.hybrid import SX, Scalar
from cosim.dae.symbolic import evaluate
from cosim.fmu.tunable import tunable_parameters
from cosim.units import parse

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
    derivative_of: int | None = None
    """Value reference of the state that this is the derivative of."""
    unit: str | None = None
    """Of a variable without declaration."""
    reinitialised: bool = False
    """A state that reinit() may set."""


@dataclass
class Layout:
    """All variables of an FMU in the order of their value references, and what the two output stores hold."""

    slots: list[Slot] = field(default_factory=list)
    outputs: list[SX] = field(default_factory=list)
    locals: list[SX] = field(default_factory=list)

    @property
    def derivatives(self) -> list[int]:
        """Value references of the state derivatives, in the order of the states."""
        return [reference for reference, slot in enumerate(self.slots) if slot.derivative_of is not None]

    @property
    def indicators(self) -> list[int]:
        """Value references of the event indicators, in the order of the relations."""
        return [reference for reference, slot in enumerate(self.slots) if slot.store == "STORE_INDICATOR"]


def lay_out(dae: Dae) -> Layout:
    """Lay out time, the published variables, the solver's counters, and what Model Exchange needs.

    The states are those of the Dae, the same ones in the same order for the whole life of an FMU: they were chosen when
    the model was compiled. A protected one is published after all, since importers have to know all states.
    """
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
    _add_states(dae, layout)
    _add_indicators(dae, layout)
    return layout


def _add_states(dae: Dae, layout: Layout) -> None:
    reinitialised = {reset.index for reset in dae.resets}
    places = {(slot.store, slot.index): k for k, slot in reversed(list(enumerate(layout.slots)))}
    references: list[int] = []
    taken = {slot.name for slot in layout.slots}
    for index, state in enumerate(dae.states):
        place = places.get(("STORE_UNKNOWN", index))
        if place is None:
            place = len(layout.slots)
            # a state that is a derivative has the name of a variable that may equal it but for a factor
            name = _free(taken, state.name, state.symbol.name())
            layout.slots.append(_continuous(name, "Protected in the model", "STORE_UNKNOWN", index))
        references.append(place)
        layout.slots[place] = replace(layout.slots[place], reinitialised=index in reinitialised)
    for index, reference in enumerate(references):
        state_slot = layout.slots[reference]
        declaration = state_slot.scalar.declaration if state_slot.scalar is not None else None
        # the derivative of a state may be a state, too; der(x,1) means the same in FMI's naming convention
        name = _free(taken, f"der({state_slot.name})", f"der({state_slot.name},1)")
        derivative = _continuous(name, f"Time derivative of {state_slot.name}", "STORE_DERIVATIVE", index)
        unit = rate_unit(declaration.unit) if declaration is not None and declaration.unit else None
        layout.slots.append(replace(derivative, derivative_of=reference, unit=unit))


def _free(taken: set[str], *names: str) -> str:
    """The first of the names that is not taken, which it is then; the last one with a number if all are."""
    numbered = (f"{names[-1]}_{number}" for number in itertools.count(2))
    name = next(name for name in itertools.chain(names, numbered) if name not in taken)
    taken.add(name)
    return name


def _add_indicators(dae: Dae, layout: Layout) -> None:
    """An event indicator for each relation but those of time alone, whose instants are known beforehand."""
    watched = [(index, relation) for index, relation in enumerate(dae.relations) if not relation.slope]
    for number, (index, relation) in enumerate(watched, start=1):
        name = f"solver.event_indicators[{number}]"
        layout.slots.append(_continuous(name, f"Event indicator of {relation.text}", "STORE_INDICATOR", index))


def _continuous(name: str, description: str, store: str, index: int) -> Slot:
    return Slot(
        name,
        None,
        description,
        store,
        index,
        "TYPE_REAL",
        "SET_NEVER",
        "local",
        "continuous",
        "calculated",
        None,
    )


def rate_unit(unit: str) -> str | None:
    """The unit of the time derivative of what has this one, ``None`` if there is none, as for degC."""
    if parse(unit).offset != 0.0:
        return None
    above, _, below = unit.partition("/")
    if not below:
        return f"{above}/s"
    if match := re.fullmatch(r"s(\d*)", below):
        return f"{above}/s{int(match[1] or 1) + 1}"
    return f"{above}/({below.removeprefix('(').removesuffix(')')}.s)"


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

"""Finding the variable that a name in a scenario means."""

from __future__ import annotations

from collections.abc import Sequence

from cosim.engine import Component, Variable
from cosim.errors import InputError
from cosim.scenario._model import suggestion

End = tuple[str, str]
"""A component's name and its variable's name."""

_CAUSALITIES = {
    "input": ("input",),
    "output": ("output",),
    "parameter": ("parameter", "structuralParameter"),
}
_SHOWN = 12


def dotted(end: End) -> str:
    """Return the name a user reads: ``plant.duty``."""
    return ".".join(end)


def resolve(name: str, components: Sequence[Component], wanted: str, called: str | None = None) -> tuple[End, Variable]:
    """Find ``name`` or ``component.name`` among the variables of a causality (`input` or `parameter`).

    ``called`` is what a message calls it. Raises `InputError` for a name that is unknown, means several variables, or
    is of another causality.
    """
    found = [
        ((component.name, own), component.fmu.variables[own])
        for component in components
        for own in {name, name.removeprefix(f"{component.name}.")}
        if own in component.fmu.variables
    ]
    fitting = [(end, variable) for end, variable in found if variable.causality in _CAUSALITIES[wanted]]
    if len(fitting) > 1:
        names = " or ".join(dotted(end) for end, _ in fitting)
        raise InputError(f"'{name}' is {wanted} of more than one component; write {names}")
    if fitting:
        return fitting[0]
    if found:
        raise _wrong_causality(*found[0], components, wanted)
    known = _known([c for c in components if name.startswith(f"{c.name}.")] or components, wanted)
    what = called or {"input": "channel", "parameter": "parameter"}[wanted]
    raise InputError(f"unknown {what} '{name}'{suggestion(name, known)}; {_listing(known, wanted)}")


def regrouped(end: End, components: Sequence[Component]) -> End:
    """Return an end that was split at its first dot, split behind the name of a component, which may have dots."""
    name = dotted(end)
    owners = [component.name for component in components if name.startswith(f"{component.name}.")]
    owner = max(owners, key=len, default=end[0])
    return owner, name.removeprefix(f"{owner}.")


def find_end(end: End, components: Sequence[Component], wanted: str) -> Variable:
    """Find a component's variable of a causality; `InputError` if there is none."""
    component = next((component for component in components if component.name == end[0]), None)
    if component is None:
        names = " and ".join(component.name for component in components)
        raise InputError(f"'{dotted(end)}': there is no component '{end[0]}'; there is {names}")
    variable = component.fmu.variables.get(end[1])
    known = _known([component], wanted)
    if variable is None:
        raise InputError(f"unknown {wanted} '{dotted(end)}'{suggestion(dotted(end), known)}; {_listing(known, wanted)}")
    if variable.causality not in _CAUSALITIES[wanted]:
        raise _wrong_causality(end, variable, [component], wanted)
    return variable


def _wrong_causality(end: End, variable: Variable, components: Sequence[Component], wanted: str) -> InputError:
    known = _known(components, wanted)
    if wanted == "parameter" and variable.causality == "input":
        column = f"{variable.name} [{variable.unit or 1}]"
        remedy = f"drive it with a column '{column}'"
    elif wanted == "input" and variable.causality in _CAUSALITIES["parameter"]:
        remedy = f"set it with '# set: {dotted(end)} = ...'"
    else:
        remedy = _listing(known, wanted)
    kind = "computed by the model" if variable.causality in ("local", "calculatedParameter") else variable.causality
    return InputError(f"'{dotted(end)}' is {_article(kind)}, not {_article(wanted)}; {remedy}")


def _article(noun: str) -> str:
    if " " in noun:
        return noun
    return f"an {noun}" if noun[0] in "aeiou" else f"a {noun}"


def _known(components: Sequence[Component], wanted: str) -> list[str]:
    return [
        f"{component.name}.{variable.name}"
        for component in components
        for variable in component.fmu.variables.values()
        if variable.causality in _CAUSALITIES[wanted]
    ]


def _listing(known: Sequence[str], wanted: str) -> str:
    """Name what there is; the first few of many."""
    if not known:
        return f"there are no {wanted}s"
    rest = len(known) - _SHOWN
    more = f" and {rest} more, which 'cosim info' lists" if rest > 0 else ""
    return f"{wanted}s are {', '.join(known[:_SHOWN])}{more}"

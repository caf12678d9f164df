"""The values that parameter sets give to parameters and inputs, in the FMUs' units and types."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

from cosim.engine import Value, Variable
from cosim.ssp._flatten import End, Flat, Path, unit_of
from cosim.ssp._model import Binding, ComponentElement, Element, MappingEntry, Parameter, SystemElement
from cosim.ssp._signals import Hop, compose
from cosim.units import Unit

_SHOWN = 8
_NUMBERS = ("Real", "Integer")


@dataclass
class Values:
    """Values of parameters with the file each comes from, start values of inputs, and notes on what sets nothing."""

    parameters: dict[End, tuple[Value, str]] = field(default_factory=dict)
    starts: dict[End, float] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class _Given:
    """A value on its way: as a number, else as text (of a Boolean 0 or 1)."""

    type: str
    number: float
    text: str
    unit: Unit | None


def values(flat: Flat) -> Values:
    """Apply all parameter bindings: those of outer systems after those of inner ones, in the order of the files.

    Raises `InputError` for a value that does not fit. A parameter that sets nothing is told in the notes: the standard
    lets a set have more than a system takes, but it may be a slip of the pen.
    """
    found = Values()
    _apply(flat, flat.structure.root, (), found)
    return found


def _apply(flat: Flat, element: Element, path: Path, found: Values) -> None:
    if isinstance(element, SystemElement):
        for name, inner in element.elements.items():
            _apply(flat, inner, (*path, name), found)
    for binding in element.bindings:
        _bind(flat, element, path, binding, found)


def _bind(flat: Flat, element: Element, path: Path, binding: Binding, found: Values) -> None:
    unused: list[str] = []
    for parameter, entry in _named(binding, found):
        name = binding.prefix + parameter.name if entry is None else entry.target
        targets = list(_targets(flat, element, path, name))
        for end, variable, unit, hops in targets:
            _set(parameter, entry, end, variable, unit, hops, binding.origin, found)
        if not targets and name not in element.connectors:
            unused.append(name)
    if unused:
        owner = f"'{'.'.join(path)}'" if path else f"system '{element.name}'"
        found.notes.append(
            f"{binding.origin}: {owner} has no parameter of the name {_listed(unused)}; nothing is set by it"
        )


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:_SHOWN]) + (f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else "")


def _named(binding: Binding, found: Values) -> Iterator[tuple[Parameter, MappingEntry | None]]:
    """Give what a binding sets; with a mapping, what is mapped and nothing else."""
    if binding.mapping is None:
        yield from ((parameter, None) for parameter in binding.parameters)
        return
    missing: list[str] = []
    by_name = {binding.prefix + parameter.name: parameter for parameter in binding.parameters}
    for entry in binding.mapping:
        array = [name for name in by_name if name.startswith(f"{entry.source}[")]
        if entry.source in by_name:
            yield by_name[entry.source], entry
        for name in array:
            yield by_name[name], replace(entry, target=entry.target + name.removeprefix(entry.source))
        if not array and entry.source not in by_name:
            missing.append(entry.source)
    if missing:
        found.notes.append(
            f"{binding.origin}: there is no parameter {_listed(missing)} for the mapping to set something"
        )


_Target = tuple[End, Variable, "Unit | None", Sequence[Hop]]


def _targets(flat: Flat, element: Element, path: Path, name: str) -> Iterator[_Target]:
    """Find the variables that a name means in an element, directly or through a connector of a system."""
    if isinstance(element, ComponentElement):
        variable = flat.fmus[path].variables.get(name)
        if variable is not None:
            unit = flat.unit((path, name)) if (path, name) in flat.connectors else unit_of(variable)
            yield (".".join(path), name), variable, unit, ()
        return
    assert isinstance(element, SystemElement)
    if name in element.connectors:
        for leaf in flat.leaves:
            keys = [key for key, _ in leaf.chain]
            if (path, name) in keys:
                after = [hop for _, hop in leaf.chain[keys.index((path, name)) + 1 :] if hop is not None]
                yield leaf.end, leaf.variable, element.connectors[name].unit, after
    for inner_name, inner in element.elements.items():
        if name.startswith(f"{inner_name}."):
            yield from _targets(flat, inner, (*path, inner_name), name.removeprefix(f"{inner_name}."))


def _set(
    parameter: Parameter,
    entry: MappingEntry | None,
    end: End,
    variable: Variable,
    unit: Unit | None,
    hops: Sequence[Hop],
    origin: str,
    found: Values,
) -> None:
    dotted = ".".join(end)
    keeps_unit, transformation = (entry.keeps_unit, entry.transformation) if entry else (False, None)
    place = entry.place if entry else parameter.place
    first = Hop(keeps_unit, transformation, unit, place, f"parameter '{parameter.name}' for {dotted}")
    given = _follow(_given(parameter), [first, *hops], variable)
    value = _fitted(given, variable, parameter, dotted)
    if not isinstance(value, str) and (missed := variable.beyond(value)):
        raise parameter.place.fail(f"{dotted} = {value:.12g} is {missed}; correct the value")
    if variable.causality == "parameter":
        found.parameters[end] = (value, origin)
    elif variable.causality == "input" and not isinstance(value, str):
        found.starts[end] = float(value)
    else:
        kind = f"a {variable.type} input" if variable.causality == "input" else f"of the causality {variable.causality}"
        raise parameter.place.fail(
            f"parameter '{parameter.name}' sets {dotted}, which is {kind}; parameters and numeric inputs can be set"
        )


def _given(parameter: Parameter) -> _Given:
    text = parameter.value
    match parameter.type:
        case "Real" | "Integer":
            try:
                number = float(text)
            except ValueError:  # SSP 2.0 has lists of numbers, for arrays
                raise parameter.place.fail(
                    f"parameter '{parameter.name}' has the value '{text}'; a scalar has one number"
                ) from None
            if math.isnan(number):
                raise parameter.place.fail(f"parameter '{parameter.name}' is not a number (NaN); give it a value")
            return _Given(parameter.type, number, text, parameter.unit)
        case "Boolean":
            if text.strip() not in ("true", "false", "0", "1"):
                raise parameter.place.fail(f"parameter '{parameter.name}' has the value '{text}'; write true or false")
            number = float(text.strip() in ("true", "1"))
            return _Given("Boolean", number, str(int(number)), None)
        case "String" | "Enumeration":
            return _Given(parameter.type, math.nan, text, None)
    raise parameter.place.fail(f"parameter '{parameter.name}' is a {parameter.type}, which cannot be set; take it out")


def _follow(given: _Given, hops: Sequence[Hop], variable: Variable) -> _Given:
    """Convert and transform a value, hop by hop."""
    for hop in hops:
        transformation = hop.transformation
        kind = "Linear" if transformation is None else transformation.kind
        if kind == "Linear":
            if given.type in _NUMBERS:
                signal = compose(given.unit, [hop])
                identity = (signal.factor, signal.offset) == (1.0, 0.0)
                number = given.number if identity else given.number * signal.factor + signal.offset
                type_ = given.type if identity else "Real"
                given = replace(given, type=type_, number=number, unit=signal.unit)
            elif transformation is not None:
                raise hop.place.fail(f"{hop.text}: a LinearTransformation of a {given.type}; it takes numbers")
            continue
        assert transformation is not None
        if given.type != kind:
            raise hop.place.fail(f"{hop.text}: a {kind}MappingTransformation of a {given.type}; it takes a {kind}")
        text = str(int(given.text)) if kind == "Integer" else given.text
        text = transformation.table.get(text, text)
        given = replace(given, text=text, number=math.nan if kind == "Enumeration" else float(text))
    return given


def _fitted(given: _Given, variable: Variable, parameter: Parameter, dotted: str) -> Value:
    """Return a value in the type of the variable."""
    match given.type, variable.type:
        case (("Real" | "Integer"), "Real"):
            return given.number
        case "Integer", "Integer":
            return int(given.text)
        case "Boolean", "Boolean":
            return bool(given.number)
        case "String", "String":
            return given.text
        case "Enumeration", "Enumeration":
            literals = variable.literals or ()
            if given.text in literals:
                return literals.index(given.text) + 1
            raise parameter.place.fail(
                f"{dotted} has no item '{given.text}'; it has {', '.join(literals) or 'no named items'}"
            )
        case "Integer", "Enumeration":
            if variable.literals is None or 1 <= given.number <= len(variable.literals):
                return int(given.number)
            raise parameter.place.fail(f"{dotted} has items 1 to {len(variable.literals)}, found {given.text}")
    raise parameter.place.fail(f"parameter '{parameter.name}' is a {given.type}, but {dotted} is a {variable.type}")

"""Parameters: checked and converted before a component is initialised."""

from __future__ import annotations

from cosim.engine.fmu._variable import Value, Variable
from cosim.engine.system._connection import dotted
from cosim.engine.system._system import Component, suggestion
from cosim.errors import FmuError

_WHY = {
    "input": "is an input; drive it by a channel or a connection",
    "output": "is an output; it cannot be set",
    "calculatedParameter": "is computed by the FMU from its other parameters; set those",
    "structuralParameter": "is a structural parameter; it can be set only when the FMU is built",
}


def parameters_of(component: Component) -> dict[str, Value]:
    """Return the parameters of a component, each in the type of its variable.

    An enumeration may be given by the name of its literal, a Boolean as 0 or 1. Raises FmuError, naming the parameter,
    if the FMU has no such parameter, it cannot be set, or the value does not fit.
    """
    return {
        name: _in_range(component, name, _converted(component, name, value))
        for name, value in component.parameters.items()
    }


def _in_range(component: Component, name: str, value: Value) -> Value:
    variable = component.fmu.variables[name]
    if not isinstance(value, str) and (missed := variable.beyond(value)):
        unit = f" {variable.unit}" if variable.unit not in (None, "1") else ""
        raise FmuError(f"{dotted((component.name, name))} = {value:.12g}{unit} is {missed}")
    return value


def _converted(component: Component, name: str, value: Value) -> Value:
    full = dotted((component.name, name))
    variable = component.fmu.variables.get(name)
    settable = {v.name for v in component.fmu.variables.values() if _is_settable(v)}
    if variable is None:
        if name in component.fmu.left_out:
            raise FmuError(f"{full}: is {component.fmu.left_out[name]}; it cannot be set")
        raise FmuError(f"{full}: {component.fmu.name} has no parameter {name}{suggestion(name, sorted(settable))}")
    if name not in settable:
        raise FmuError(f"{full}: {_WHY.get(variable.causality, 'is no parameter; it cannot be set')}")
    if variable.type == "Binary":
        return _checked_binary(full, variable, value)
    if variable.type == "String":
        if isinstance(value, str):
            return value
    elif isinstance(value, str):
        if variable.literals and value in variable.literals:
            return variable.literals.index(value) + 1
    elif variable.type == "Real":
        return float(value)
    elif value == int(value) and (variable.type != "Boolean" or value in (0, 1)):
        return bool(value) if variable.type == "Boolean" else int(value)
    raise FmuError(f"{full}: {value!r} does not fit; it takes {_accepted(variable)}")


def _checked_binary(full: str, variable: Variable, value: Value) -> str:
    """Return the hexadecimal digits of a Binary if they are such, and no more bytes than it may have."""
    try:
        size = len(bytes.fromhex(value if isinstance(value, str) else "?"))
    except ValueError:
        message = f"{full}: {value!r} does not fit; it takes a text of two hexadecimal digits for each byte"
        raise FmuError(message) from None
    most = variable.binary.most if variable.binary else None
    if most is not None and size > most:
        raise FmuError(f"{full}: has {size} bytes; it takes at most {most}")
    return str(value)


def _is_settable(variable: Variable) -> bool:
    return variable.causality == "parameter" and variable.variability in ("fixed", "tunable")


def _accepted(variable: Variable) -> str:
    if variable.literals:
        return f"one of {', '.join(variable.literals)}"
    return {"Real": "a number", "Boolean": "true or false (1 or 0)", "String": "a text"}.get(
        variable.type, "a whole number"
    )

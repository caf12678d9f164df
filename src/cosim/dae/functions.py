"""Calls of the model's own functions: their statements are run on the arguments' values, and nothing is left of them.

Inside a function relations make no events (Modelica 3.7.3.1, 12.2), and only its own variables and constants are known.
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from cosim.dae.hybrid import SX
from cosim.dae.statements import State, missing, nothing, run
from cosim.dae.symbols import Evaluate
from cosim.dae.texts import text
from cosim.modelica.expressions import Expression, Literal, UserCall, references, render
from cosim.modelica.flat import Function, Local


def call(evaluate: Evaluate, node: UserCall, position: int = 0) -> SX:
    """The value of one of the outputs of a call.

    A function of scalars that is called with arrays is called for each element (Modelica 12.4.6).

    Raises:
        ModelError: the function cannot be inlined, or the call does not fit it; by name and place.
    """
    function = _function(evaluate, node)
    if position >= len(function.outputs):
        raise evaluate.error(f"{function.name} has {len(function.outputs)} outputs", node)
    output = function.outputs[position]
    arguments = _arguments(evaluate, function, node)
    shape = _elementwise(evaluate, function, node, arguments)
    if shape is None:
        return _output(evaluate, function, node, output, arguments)
    values = []
    for k in range(shape[0] * shape[1]):
        one = [a[k] if a is not None and not i.dimensions and a.numel() > 1 else a
               for i, a in zip(function.inputs, arguments, strict=True)]  # fmt: skip
        values.append(_output(evaluate, function, node, output, one))
    if any(value.numel() != 1 for value in values):
        raise evaluate.error(f"{render(node)}: only a function of scalars can be called for each element", node)
    return ca.reshape(ca.vertcat(*values), *shape)


def components(evaluate: Evaluate, node: UserCall, position: int = 0) -> list[str] | None:
    """The names of the components of an output that is a record; ``None`` if it is none."""
    function = _function(evaluate, node)
    if function.is_constructor:
        return [variable.name for variable in function.inputs]
    name = function.outputs[position].name
    if function.outputs[position].type in _PREDEFINED:
        return None
    state = _run(evaluate, function, node, _arguments(evaluate, function, node))
    return [key[len(name) + 1 :] for key in state if key.startswith(f"{name}.")] or None


def component(evaluate: Evaluate, node: UserCall, name: str, position: int = 0) -> SX:
    """The value of a component of an output that is a record."""
    function = _function(evaluate, node)
    arguments = _arguments(evaluate, function, node)
    if function.is_constructor:
        for variable, argument in zip(function.inputs, arguments, strict=True):
            if variable.name == name.replace(".", "_") and argument is not None:
                return argument
        raise evaluate.error(f"{function.name} has no component {name}", node)
    state = _run(evaluate, function, node, arguments)
    return _value(evaluate, function, node, f"{function.outputs[position].name}.{name}", state)


_PREDEFINED = {"Real", "Integer", "Boolean", "String"}


def _function(evaluate: Evaluate, node: UserCall) -> Function:
    function = evaluate.symbols.flat.functions.get(node.function)
    if function is None:
        raise evaluate.error(f"the function {node.function} is not known here", node)
    if function.name in evaluate.function:
        raise evaluate.error(
            f"{function.name} calls itself; functions that call themselves are not supported, use a for-loop", node
        )
    return function


def _arguments(evaluate: Evaluate, function: Function, node: UserCall) -> list[SX | None]:
    """The values of the inputs; ``None`` for texts."""
    if len(node.arguments) > len(function.inputs):
        raise evaluate.error(f"{function.name} has {len(function.inputs)} inputs", node)
    values: list[SX | None] = []
    for position, variable in enumerate(function.inputs):
        if variable.type == "String":
            values.append(None)
        else:
            values.append(evaluate(_argument(evaluate, function, node, position)))
    return values


def _argument(evaluate: Evaluate, function: Function, node: UserCall, position: int) -> Expression:
    default = function.inputs[position].value
    if position < len(node.arguments):
        return node.arguments[position]
    if default is None:
        raise evaluate.error(f"{render(node)}: the input {function.inputs[position].name} is missing", node)
    return default


def _elementwise(
    evaluate: Evaluate, function: Function, node: UserCall, arguments: Sequence[SX | None]
) -> tuple[int, int] | None:
    """The shape over which a function is called for each element."""
    shapes = {a.shape for i, a in zip(function.inputs, arguments, strict=True)
              if a is not None and not i.dimensions and a.numel() != 1}  # fmt: skip
    if len(shapes) > 1:
        raise evaluate.error(f"{render(node)}: the arrays have different sizes", node)
    return shapes.pop() if shapes else None


def _output(
    evaluate: Evaluate, function: Function, node: UserCall, output: Local, arguments: Sequence[SX | None]
) -> SX:
    return _value(evaluate, function, node, output.name, _run(evaluate, function, node, arguments))


def _value(evaluate: Evaluate, function: Function, node: UserCall, name: str, state: State) -> SX:
    if name not in state or missing(state[name]):
        raise evaluate.error(f"{render(node)}: {function.name} does not give {name} a value in every case", node)
    return state[name]


def _run(evaluate: Evaluate, function: Function, node: UserCall, arguments: Sequence[SX | None]) -> State:
    """The values of all variables of the function at its end."""
    values: State = {i.name: a for i, a in zip(function.inputs, arguments, strict=True) if a is not None}
    texts = {
        variable.name: text(evaluate, _argument(evaluate, function, node, position))
        for position, variable in enumerate(function.inputs)
        if variable.type == "String" and _is_text(evaluate, _argument(evaluate, function, node, position))
    }
    own = (*function.inputs, *function.outputs, *function.locals)
    inside = evaluate.alike(
        locals={},
        ranks={variable.name: len(variable.dimensions) for variable in own},
        texts=texts,
        function=(*evaluate.function, function.name),
        no_event=True,
        reading_pre=False,
    )
    for variable in function.inputs:
        given = values.get(variable.name)
        sizes = [None if d is None else inside.alike(locals=values).indices(d)[0] for d in variable.dimensions]
        if given is not None and any(size not in (None, given.shape[k]) for k, size in enumerate(sizes)):
            wanted = ", ".join(":" if size is None else str(size) for size in sizes)
            raise evaluate.error(
                f"{render(node)}: the input {variable.name}[{wanted}] gets an array of {given.shape[0]} x"
                f" {given.shape[1]}",
                node,
            )
    for variable in _ordered([*function.outputs, *function.locals]):
        knowing = inside.alike(locals=values)
        if variable.type == "String":
            raise evaluate.error(f"{function.name}: the variable {variable.name} is a String; that is not supported",
                                 Literal(0, variable.at))  # fmt: skip
        if variable.type not in _PREDEFINED and variable.type not in _enumerations(evaluate):
            if variable.value is not None:
                for name in knowing.components(variable.value) or ():
                    values[f"{variable.name}.{name}"] = knowing.component(variable.value, name)
            continue
        shape = [1 if d is None else knowing.indices(d)[0] for d in variable.dimensions]
        values[variable.name] = nothing(*shape) if variable.value is None else knowing(variable.value)
    state = {name: value for name, value in values.items() if name not in {i.name for i in function.inputs}}
    arguments_only = {i.name: values[i.name] for i in function.inputs if i.name in values}
    return run(inside.alike(locals=arguments_only), function.body, state)


def _enumerations(evaluate: Evaluate) -> set[str]:
    full = {name.rpartition(".")[0] for name in evaluate.symbols.flat.enumeration_values}
    return full | {name.rpartition(".")[2] for name in full}


def _is_text(evaluate: Evaluate, expression: Expression) -> bool:
    return isinstance(expression, Literal) or any(
        name in evaluate.texts or name in evaluate.symbols.flat.variables for name in references(expression)
    )


def _ordered(variables: list[Local]) -> list[Local]:
    """Each after the ones that its size and initial value use."""
    result: list[Local] = []
    while variables:
        open_names = {variable.name for variable in variables}
        ready = [variable for variable in variables if not (open_names - {variable.name}) & set(_used(variable))]
        result += ready or variables
        variables = [variable for variable in variables if ready and variable not in ready]
    return result


def _used(variable: Local) -> list[str]:
    expressions = [*variable.dimensions, variable.value]
    return [name for expression in expressions if expression is not None for name in references(expression)]

"""The texts of messages: literals, String parameters, and in their place the names of quantities that are shown."""

from __future__ import annotations

from cosim.dae.symbols import Evaluate
from cosim.modelica.expressions import Binary, Call, Expression, Literal, Reference, render


def text(evaluate: Evaluate, expression: Expression) -> str:
    """The text of a message, which is fixed when the model is compiled: ``String(x)`` becomes ``<x>``.

    Raises:
        ModelError: it is not made of literals, String parameters, String() and ``+``.
    """
    match expression:
        case Literal(value=str(value)):
            return value
        case Binary(operator="+", left=left, right=right):
            return text(evaluate, left) + text(evaluate, right)
        case Call(function="String", arguments=(argument, *_)):
            return str(argument.value) if isinstance(argument, Literal) else f"<{render(argument)}>"
        case Reference(name=name, subscripts=()):
            if name in evaluate.texts:
                return evaluate.texts[name]
            variable = evaluate.symbols.flat.variables.get(name)
            if variable is not None and variable.type == "String" and variable.variability in ("parameter", "constant"):
                given = variable.binding if variable.binding is not None else variable.start
                if given is not None:
                    return text(evaluate, given)
    raise evaluate.error(
        f"{render(expression)}: a message can be made of literals, String parameters, String(x) and +", expression
    )

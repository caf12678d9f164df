"""Modelica's operators that have to do with time and events: der, pre, sample, floor and what is made of them."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca

from cosim.dae.hybrid import SX, Clock
from cosim.dae.symbols import Evaluate, Held, Mode, declare_held
from cosim.modelica.expressions import Call, render

_INITIAL = "$initial"
HELD_FLOOR = "$floor"
"""How the names of held integers begin."""


def _der(evaluate: Evaluate, node: Call) -> SX:
    if evaluate.mode is Mode.PARAMETER:
        raise evaluate.error("der() has no place in a parameter's value or a start", node)
    system = evaluate.symbols.system
    value = evaluate(node.arguments[0])
    result = ca.jacobian(ca.vec(value), system.time)
    for symbol in ca.symvar(value):
        name = symbol.name()
        inner = name
        while inner.startswith("der("):
            inner = inner[4:-1]
        if inner in system.unknowns:
            result = result + ca.jacobian(ca.vec(value), symbol) * system.derivative(name)
        elif name in system.inputs:
            raise evaluate.error(f"{render(node)} needs the derivative of the input {name}, which is not known", node)
    return ca.simplify(ca.reshape(result, *value.shape))


def _pre(evaluate: Evaluate, node: Call) -> SX:
    if evaluate.mode in (Mode.PARAMETER, Mode.CONTINUOUS):
        raise evaluate.error("pre() has no place in a continuous equation", node)
    return evaluate.alike(reading_pre=True)(node.arguments[0])


def _edge(evaluate: Evaluate, node: Call) -> SX:
    return ca.logic_and(evaluate(node.arguments[0]), ca.logic_not(_pre(evaluate, node)))


def _change(evaluate: Evaluate, node: Call) -> SX:
    return evaluate(node.arguments[0]) != _pre(evaluate, node)


def _initial(evaluate: Evaluate, node: Call) -> SX:
    symbols = evaluate.symbols
    if evaluate.mode is Mode.PARAMETER:
        raise evaluate.error("initial() has no place in a parameter's value or a start", node)
    if evaluate.mode is not Mode.CONTINUOUS:
        return symbols.system.initial
    if _INITIAL not in symbols.values:
        declare_held(symbols, _INITIAL, "Boolean")
        symbols.held.append(Held(_INITIAL, symbols.system.initial, "initial()", node.at))
    return symbols.values[_INITIAL]


def _sample(evaluate: Evaluate, node: Call) -> SX:
    if evaluate.mode is not Mode.DISCRETE:
        raise evaluate.error("sample() can stand only in a when-condition", node)
    parameter = evaluate.alike(mode=Mode.PARAMETER)
    start, interval = (parameter(argument) for argument in node.arguments)
    clocks = evaluate.symbols.system.clocks
    for clock in clocks:
        if not clock.terminal and ca.is_equal(clock.start, start, 10) and ca.is_equal(clock.interval, interval, 10):
            return clock.fired
    clocks.append(Clock(SX.sym(f"fired({len(clocks)})"), start, interval))
    return clocks[-1].fired


def _terminal(evaluate: Evaluate, node: Call) -> SX:
    if evaluate.mode is not Mode.DISCRETE:
        raise evaluate.error("terminal() can stand only in a when-condition", node)
    clocks = evaluate.symbols.system.clocks
    for clock in clocks:
        if clock.terminal:
            return clock.fired
    clocks.append(Clock(SX.sym("terminal()"), SX(float("inf")), SX(float("inf")), terminal=True))
    return clocks[-1].fired


def _floor(evaluate: Evaluate, node: Call) -> SX:
    return _held_floor(evaluate, evaluate(node.arguments[0]), node)


def _ceil(evaluate: Evaluate, node: Call) -> SX:
    return -_held_floor(evaluate, -evaluate(node.arguments[0]), node)


def _mod(evaluate: Evaluate, node: Call) -> SX:
    x, y = (evaluate(argument) for argument in node.arguments)
    return x - _held_floor(evaluate, x / y, node) * y


def _div(evaluate: Evaluate, node: Call) -> SX:
    """The algebraic quotient without its fraction (Modelica 3.7.2): floor where it is positive, else ceil."""
    x, y = (evaluate(argument) for argument in node.arguments)
    quotient = x / y
    if _is_plain(evaluate, quotient):
        return ca.if_else(quotient >= 0, ca.floor(quotient), ca.ceil(quotient))
    positive = evaluate.event(quotient, False, f"{render(node)} is positive")
    down, up = _held_floor(evaluate, quotient, node), -_held_floor(evaluate, -quotient, node)
    return ca.if_else(positive, down, up)


def _rem(evaluate: Evaluate, node: Call) -> SX:
    x, y = (evaluate(argument) for argument in node.arguments)
    return x - _div(evaluate, node) * y


def _is_plain(evaluate: Evaluate, value: SX) -> bool:
    sampled = evaluate.mode in (Mode.PARAMETER, Mode.SAMPLED)
    return sampled or evaluate.no_event or not evaluate.varies(value)


def _held_floor(evaluate: Evaluate, value: SX, node: Call) -> SX:
    """floor(value): between events it is a held integer, and leaving [k, k+1) is the event (Modelica 3.7.2)."""
    if _is_plain(evaluate, value):
        return ca.floor(value)
    if not value.is_scalar():
        return ca.reshape(
            ca.vertcat(*(_held_floor(evaluate, element, node) for element in ca.vertsplit(ca.vec(value)))), *value.shape
        )
    symbols, text = evaluate.symbols, render(node)
    name = next((h.name for h in symbols.held if ca.is_equal(h.value, ca.floor(value), 50)), None)
    if name is None:
        name = f"{HELD_FLOOR}{len(symbols.held) + 1}"
        symbols.held.append(Held(name, ca.floor(value), f"floor in {text}", node.at))
        declare_held(symbols, name)
        held = symbols.values[name]
        evaluate.event(value - held, False, f"{text} steps down")
        evaluate.event(held + 1 - value, True, f"{text} steps up")
    return symbols.values[name] if evaluate.mode is Mode.CONTINUOUS else symbols.new[name]


def _semi_linear(evaluate: Evaluate, node: Call) -> SX:
    """semiLinear(x, a, b) = if x >= 0 then a x else b x (Modelica 3.7.4.5); its simpler solutions are not chosen."""
    x, a, b = (evaluate(argument) for argument in node.arguments)
    smooth = evaluate.mode in (Mode.PARAMETER, Mode.SAMPLED) or evaluate.no_event or not evaluate.varies(x)
    positive = x >= 0 if smooth else evaluate.event(x, False, f"{render(node.arguments[0])} >= 0")
    return ca.if_else(positive, a * x, b * x)


def _without_events(evaluate: Evaluate, node: Call) -> SX:
    return evaluate.alike(no_event=True)(node.arguments[-1])


EVENT_FUNCTIONS: dict[str, Callable[[Evaluate, Call], SX]] = {
    "der": _der,
    "pre": _pre,
    "edge": _edge,
    "change": _change,
    "initial": _initial,
    "terminal": _terminal,
    "sample": _sample,
    "floor": _floor,
    "integer": _floor,
    "ceil": _ceil,
    "mod": _mod,
    "div": _div,
    "rem": _rem,
    "semiLinear": _semi_linear,
    "noEvent": _without_events,
    "smooth": _without_events,
    "homotopy": lambda evaluate, node: evaluate(node.arguments[0]),
}
"""By Modelica name."""

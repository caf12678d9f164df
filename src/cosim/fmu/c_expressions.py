"""Prints a CasADi SX function as straight-line C: one constant per operation, in the order CasADi evaluates them."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

import casadi as ca

BINARY = {
    ca.OP_ADD: "{} + {}", ca.OP_SUB: "{} - {}", ca.OP_MUL: "{} * {}", ca.OP_DIV: "{} / {}",
    ca.OP_POW: "pow({}, {})", ca.OP_CONSTPOW: "pow({}, {})", ca.OP_FMOD: "fmod({}, {})",
    ca.OP_FMIN: "fmin({}, {})", ca.OP_FMAX: "fmax({}, {})", ca.OP_ATAN2: "atan2({}, {})",
    ca.OP_HYPOT: "hypot({}, {})", ca.OP_COPYSIGN: "copysign({}, {})",
    ca.OP_LT: "{} < {}", ca.OP_LE: "{} <= {}", ca.OP_EQ: "{} == {}", ca.OP_NE: "{} != {}",
    ca.OP_AND: "{} != 0 && {} != 0", ca.OP_OR: "{} != 0 || {} != 0", ca.OP_IF_ELSE_ZERO: "{} != 0 ? {} : 0",
}  # fmt: skip
UNARY = {
    ca.OP_NEG: "-{}", ca.OP_SQ: "{0} * {0}", ca.OP_TWICE: "2 * {}", ca.OP_INV: "1 / {}", ca.OP_NOT: "{} == 0",
    ca.OP_SQRT: "sqrt({})", ca.OP_EXP: "exp({})", ca.OP_LOG: "log({})",
    ca.OP_SIN: "model_sin({})", ca.OP_COS: "model_cos({})",
    ca.OP_TAN: "tan({})", ca.OP_ASIN: "asin({})", ca.OP_ACOS: "acos({})", ca.OP_ATAN: "atan({})",
    ca.OP_SINH: "sinh({})", ca.OP_COSH: "cosh({})", ca.OP_TANH: "tanh({})", ca.OP_FABS: "fabs({})",
    ca.OP_FLOOR: "floor({})", ca.OP_CEIL: "ceil({})", ca.OP_SIGN: "(({0} > 0) - ({0} < 0))",
    ca.OP_LOG1P: "log1p({})", ca.OP_EXPM1: "expm1({})", ca.OP_ASINH: "asinh({})", ca.OP_ACOSH: "acosh({})",
    ca.OP_ATANH: "atanh({})", ca.OP_ASSIGN: "{}",
}  # fmt: skip
SCALARS = frozenset({"t", "initial"})
"""Arguments of the generated functions that are not arrays."""
_RESERVED = frozenset(
    """
    auto break case char const continue default do double else enum extern float for goto if inline int long register
    restrict return short signed sizeof static struct switch typedef union unsigned void volatile while
    t v u p d c f g J y dz l r ft pre fired initial d_new x_new start interval
    sin cos tan asin acos atan atan2 sinh cosh tanh exp log sqrt pow fabs floor ceil fmod fmin fmax hypot gamma
    model_sin model_cos model_has_nan
    j0 j1 jn y0 y1 yn index remainder signbit round trunc main abs div time signal
    """.split()
)


class Names:
    """C identifiers for Modelica names, unique within one function."""

    def __init__(self) -> None:
        """Start with none taken."""
        self._taken: set[str] = set()

    def identifier(self, name: str) -> str:
        """A C identifier that a reader recognises the name by."""
        plain = re.sub(r"\W+", "_", name).strip("_") or "x"
        if plain[0].isdigit() or plain in _RESERVED or re.fullmatch(r"t\d+", plain):
            plain = f"x_{plain}"
        candidate, count = plain, 1
        while candidate in self._taken:
            count += 1
            candidate = f"{plain}_{count}"
        self._taken.add(candidate)
        return candidate


def print_function(
    function: ca.Function,
    arguments: Sequence[str],
    results: Sequence[str],
    labels: Sequence[Sequence[str]],
    most_named: int = 400,
) -> list[str]:
    """The body of a C function that evaluates ``function``.

    Args:
        function: an SX function whose results are dense.
        arguments: C name of each argument; an empty-subscript scalar argument is written without index.
        results: C name of the array each result goes to.
        labels: for each argument, the Modelica name of each entry.
        most_named: an argument that uses more entries than this is indexed in place instead of named.

    Raises:
        NotImplementedError: CasADi made an operation this printer does not know; a defect, not a user's mistake.
    """
    names = Names()
    used = _used_inputs(function)
    lines: list[str] = []
    register: dict[int, str] = {}
    inputs: dict[tuple[int, int], str] = {}
    for argument, entries in sorted(used.items()):
        scalar = arguments[argument] in SCALARS
        for entry in sorted(entries):
            place = arguments[argument] if scalar else f"{arguments[argument]}[{entry}]"
            if scalar or len(entries) > most_named:
                inputs[argument, entry] = place
            else:
                inputs[argument, entry] = names.identifier(labels[argument][entry])
                lines.append(f"const double {inputs[argument, entry]} = {place};")
    count = 0
    for k in range(function.n_instructions()):
        operation = function.instruction_id(k)
        reads, writes = function.instruction_input(k), function.instruction_output(k)
        if operation == ca.OP_CONST:
            register[writes[0]] = number(function.instruction_constant(k))
        elif operation == ca.OP_INPUT:
            register[writes[0]] = inputs[reads[0], reads[1]]
        elif operation == ca.OP_OUTPUT:
            lines.append(f"{results[writes[0]]}[{writes[1]}] = {register[reads[0]]};")
        else:
            pattern = BINARY.get(operation) or UNARY.get(operation)
            if pattern is None:
                raise NotImplementedError(f"CasADi operation {operation} has no C text")
            operands = [register[r] for r in reads]
            count += 1
            lines.append(f"const double t{count} = {pattern.format(*operands)};")
            register[writes[0]] = f"t{count}"
    return lines


def number(value: float) -> str:
    """A C literal that reads back as the same double."""
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0 else "(-INFINITY)"
    text = repr(float(value))
    return f"({text})" if value < 0 else text


def _used_inputs(function: ca.Function) -> dict[int, set[int]]:
    used: dict[int, set[int]] = {}
    for k in range(function.n_instructions()):
        if function.instruction_id(k) == ca.OP_INPUT:
            argument, entry = function.instruction_input(k)
            used.setdefault(argument, set()).add(entry)
    return used

"""Prints a CasADi SX function as straight-line C, with the names of the model's variables where they are computed."""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

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
SCALARS = frozenset({"t", "initial", "t_dot"})
"""Arguments of the generated functions that are not arrays."""
MOST_NAMED = 400
"""An argument that uses more entries than this is indexed in place instead of named."""
_RESERVED = frozenset(
    """
    auto break case char const continue default do double else enum extern float for goto if inline int long register
    restrict return short signed sizeof static struct switch typedef union unsigned void volatile while
    t_dot v_dot u_dot f_dot y_dot t_bar v_bar u_bar p_bar f_bar y_bar r_bar free_bar own A k
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
        self._temporaries = 0

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

    def temporary(self) -> str:
        """The next of t1, t2, ..., which no Modelica name becomes."""
        self._temporaries += 1
        return f"t{self._temporaries}"


@dataclass(frozen=True)
class _Node:
    """One value of a function: an operation, an input with its place, or a constant with its C text."""

    operation: int
    operands: tuple[int, ...] = ()
    place: tuple[int, int] = (0, 0)
    text: str = ""


class _Graph:
    """The values of an SX function in the order of computation, each written once."""

    def __init__(self, function: ca.Function) -> None:
        """Read the instructions of ``function``, which reuse their registers."""
        self.nodes: list[_Node] = []
        self.outputs: list[tuple[int, int, int]] = []
        """(result, entry, node)"""
        register: dict[int, int] = {}
        for k in range(function.n_instructions()):
            operation = function.instruction_id(k)
            reads, writes = function.instruction_input(k), function.instruction_output(k)
            if operation == ca.OP_OUTPUT:
                self.outputs.append((writes[0], writes[1], register[reads[0]]))
                continue
            if operation == ca.OP_CONST:
                node = _Node(operation, text=number(function.instruction_constant(k)))
            elif operation == ca.OP_INPUT:
                node = _Node(operation, place=(reads[0], reads[1]))
            else:
                node = _Node(operation, tuple(register[r] for r in reads))
            register[writes[0]] = len(self.nodes)
            self.nodes.append(node)

    def readers(self, results: int) -> list[list[int]]:
        """Which operations read each node on the way to the first ``results`` results; -1 for a result itself."""
        found: list[list[int]] = [[] for _ in self.nodes]
        for result, _, node in self.outputs:
            if result < results:
                found[node].append(-1)
        for k in reversed(range(len(self.nodes))):
            if found[k]:
                for operand in self.nodes[k].operands:
                    found[operand].append(self.nodes[k].operation)
        return found


def print_function(
    function: ca.Function,
    arguments: Sequence[str],
    results: Sequence[str],
    labels: Sequence[Sequence[str]],
    named: Sequence[tuple[str, str]] = (),
    most_named: int = MOST_NAMED,
) -> list[str]:
    """The body of a C function that evaluates ``function``.

    A value that is read once and takes few operations stands where it is read; every other one has a line of its own.

    Args:
        function: an SX function whose results are dense.
        arguments: C name of each argument; an empty-subscript scalar argument is written without index.
        results: C name of the array each result goes to.
        labels: for each argument, the Modelica name of each entry.
        named: for each entry of one more result of ``function``, a Modelica name and a remark. It is not written; its
            values get these names if they are needed for the other results.
        most_named: an argument that uses more entries than this is indexed in place instead of named.

    Raises:
        NotImplementedError: CasADi made an operation this printer does not know; a defect, not a user's mistake.
    """
    names = Names()
    lines: list[str] = []
    graph = _Graph(function)
    readers = graph.readers(len(results))
    used: dict[int, set[int]] = defaultdict(set)
    for node, its_readers in zip(graph.nodes, readers, strict=True):
        if node.operation == ca.OP_INPUT and its_readers:
            used[node.place[0]].add(node.place[1])
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
    titles: dict[int, tuple[str, str]] = {}
    for result, entry, source in graph.outputs:
        if result == len(results):
            titles.setdefault(source, named[entry])
    spelt: list[_Spelt] = []
    for k, node in enumerate(graph.nodes):
        if not node.operands or not readers[k]:
            spelt.append(_Spelt(inputs.get(node.place, "") if node.operation == ca.OP_INPUT else node.text, _ATOM, 0))
            continue
        value = _spell(node, [spelt[operand] for operand in node.operands])
        if k not in titles and value.size <= LONGEST and _may_stand_inside(node, readers[k]):
            spelt.append(value)
            continue
        name, remark = titles.get(k, ("", ""))
        identifier = names.identifier(name) if name else names.temporary()
        comment = f" /* {remark} */" if remark else ""
        lines.append(f"const double {identifier} = {value.text};{comment}")
        spelt.append(_Spelt(identifier, _ATOM, 0))
    for result, entry, source in graph.outputs:
        if result < len(results):
            lines.append(f"{results[result]}[{entry}] = {spelt[source].text};")
    return lines


LONGEST = 8
"""The most operations that are written inside another one."""
_ATOM, _PRODUCT, _SUM, _LOOSE = 3, 2, 1, 0
_SUMS = (_SUM, (_SUM, _PRODUCT))
_PRODUCTS = (_PRODUCT, (_PRODUCT, _ATOM))
_COMPARISONS = (_LOOSE, (_SUM, _SUM))
_BINDING: dict[int, tuple[int, tuple[int, ...]]] = {
    ca.OP_ADD: _SUMS, ca.OP_SUB: _SUMS, ca.OP_MUL: _PRODUCTS, ca.OP_DIV: _PRODUCTS,
    ca.OP_TWICE: (_PRODUCT, (_ATOM,)), ca.OP_INV: (_PRODUCT, (_ATOM,)), ca.OP_SQ: (_PRODUCT, (_ATOM,)),
    ca.OP_NEG: (_LOOSE, (_ATOM,)), ca.OP_NOT: (_LOOSE, (_SUM,)), ca.OP_ASSIGN: (_LOOSE, (_LOOSE,)),
    **dict.fromkeys(
        (ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE, ca.OP_AND, ca.OP_OR, ca.OP_IF_ELSE_ZERO), _COMPARISONS
    ),
}  # fmt: skip
"""How tightly an operation binds, and how tightly its operands must lest they need parentheses; none for functions."""
_INTEGERS = frozenset({ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE, ca.OP_AND, ca.OP_OR, ca.OP_NOT, ca.OP_SIGN})
"""Their values are integers in C, which must become double before they are divided."""
_LOGICAL = frozenset({ca.OP_AND, ca.OP_OR, ca.OP_NOT})
_REPEATED = frozenset({ca.OP_SQ, ca.OP_SIGN})
"""They write their operand twice."""


@dataclass(frozen=True)
class _Spelt:
    """C text of a value, how tightly its outermost operation binds, how many operations it spells out."""

    text: str
    binding: int
    size: int


def _may_stand_inside(node: _Node, readers: Sequence[int]) -> bool:
    """Whether its only reader (an operation, or -1 for a result) can take its text instead of a name."""
    if len(readers) != 1 or readers[0] in _REPEATED:
        return False
    return node.operation not in _INTEGERS or readers[0] in _LOGICAL or readers[0] == -1


def _spell(node: _Node, operands: Sequence[_Spelt]) -> _Spelt:
    """An operation on its operands' texts, with the parentheses that keep the order of computation."""
    pattern = BINARY.get(node.operation) or UNARY.get(node.operation)
    if pattern is None:
        raise NotImplementedError(f"CasADi operation {node.operation} has no C text")
    binding, least = _BINDING.get(node.operation, (_ATOM, (_LOOSE, _LOOSE)))
    texts = [o.text if o.binding >= tight else f"({o.text})" for o, tight in zip(operands, least, strict=False)]
    return _Spelt(pattern.format(*texts), binding, 1 + sum(o.size for o in operands))


def number(value: float) -> str:
    """A C literal that reads back as the same double."""
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0 else "(-INFINITY)"
    text = repr(float(value))
    return f"({text})" if value < 0 else text

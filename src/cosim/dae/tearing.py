"""Solves each block symbolically where that is safe, and tears the rest.

What may be divided by: a number, an expression of parameters that is not zero by default, and an expression that some
block of the whole system needs to be nonzero anyway (for instance the Jacobian determinant of a closed loop, which is
nonzero wherever the loop's angles are determined at all). Anything else could vanish where the model itself is regular,
and would be a singularity of our own making. Linear blocks that cannot be reduced this way are solved as a whole: up to
three unknowns by Cramer's rule, which divides by the determinant only, larger ones by a symbolic QR factorisation.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import casadi as ca
import numpy as np
import numpy.typing as npt

from cosim.dae.blocks import triangular
from cosim.dae.hybrid import SX
from cosim.dae.rank import dependent_rows, has_full_rank
from cosim.dae.symbolic import depends, evaluate, substitute

CRAMER = 3
"""Systems up to this size are solved by Cramer's rule."""
_POINTS = 5
_TRIES = 50
_SINGULAR = 1e-12


@dataclass(frozen=True)
class Block:
    """What ``--explain`` tells of a block."""

    kind: str
    """"explicit", "linear" or "implicit"."""
    unknowns: tuple[str, ...]
    torn: tuple[str, ...]
    equations: tuple[int, ...]

    def __str__(self) -> str:
        """Kind, size and how it is solved."""
        how = f"torn in {', '.join(self.torn)}" if self.torn else "solved symbolically"
        return f"{self.kind}, {len(self.unknowns)} unknown{'s' * (len(self.unknowns) != 1)}, {how}"


@dataclass
class Solution:
    """How the unknowns follow from what is known.

    ``steps`` are (symbol, expression) in the order of computation; ``torn`` are found by the solver so that
    ``residuals`` vanish.
    """

    steps: list[tuple[SX, SX]] = field(default_factory=list)
    torn: list[SX] = field(default_factory=list)
    residuals: list[SX] = field(default_factory=list)
    residual_equations: list[int] = field(default_factory=list)
    blocks: list[Block] = field(default_factory=list)


def solve(
    residuals: list[SX], unknowns: list[SX], tear_first: set[str], parameters: dict[str, float]
) -> Solution | None:
    """Solve ``residuals = 0`` for ``unknowns``; ``None`` if structurally singular.

    Args:
        residuals: one expression an equation.
        unknowns: as many symbols.
        tear_first: names of the unknowns that are preferred as tearing variables (derivatives of states).
        parameters: names and default values of the parameters.

    Raises:
        Singular: some of the equations depend on each other.
    """
    tearer = _Tearer(residuals, unknowns, tear_first, parameters)
    return tearer.solution if tearer.run() else None


class Singular(Exception):  # noqa: N818 - not an error of the program, caught by the caller
    """Some equations do not determine their unknowns, whatever the numbers in them are."""

    def __init__(self, equations: list[int], unknowns: list[int]) -> None:
        """Note which."""
        super().__init__(equations, unknowns)
        self.equations = equations
        self.unknowns = unknowns


class _Tearer:
    def __init__(
        self, residuals: list[SX], unknowns: list[SX], tear_first: set[str], parameters: dict[str, float]
    ) -> None:
        self._residuals = residuals
        self._unknowns = unknowns
        self._names = [u.name() for u in unknowns]
        column = {name: j for j, name in enumerate(self._names)}
        self._incidence = [[column[s.name()] for s in ca.symvar(r) if s.name() in column] for r in residuals]
        self._tear_first = tear_first
        self._parameters = parameters
        self._full: dict[str, SX] = {}
        """Each computed unknown in terms of what is known from outside and torn."""
        self._regular: list[SX] = []
        self._random = np.random.default_rng(20180601)
        self._points: list[dict[str, float]] = [{} for _ in range(_POINTS)]
        self.solution = Solution()

    def run(self) -> bool:
        blocks = triangular(self._incidence, len(self._unknowns))
        if blocks is None:
            return False
        for equations, columns in blocks:
            self._block(equations, columns)
        return True

    # one block of the whole system

    def _block(self, equations: list[int], columns: list[int]) -> None:
        start = len(self.solution.torn)
        self._refuse_singular(equations, columns)
        if len(equations) == 1 and self._linear(equations, columns):
            (row,), (j,) = equations, columns
            self._regular.append(self._coefficient(row, j))
            self._assign(j, self._explicit(row, j))
            kind = "explicit"
        else:
            kind = "linear" if self._linear(equations, columns) else "implicit"
            self._coupled(equations, columns, linear=kind == "linear")
        torn = tuple(s.name() for s in self.solution.torn[start:])
        names = tuple(self._names[j] for j in columns)
        self.solution.blocks.append(Block(kind, names, torn, tuple(equations)))

    def _refuse_singular(self, equations: list[int], columns: list[int]) -> None:
        """Refuse a block that is singular for any values; ``Singular`` has the smallest part that is."""
        unknown = ca.vertcat(*(self._unknowns[j] for j in columns))
        jacobian = ca.densify(ca.jacobian(ca.vertcat(*(self._residuals[row] for row in equations)), unknown))
        symbols = ca.symvar(jacobian)
        function = ca.Function("J", [ca.vertcat(SX(0, 1), *symbols)], [jacobian])
        # conditions of if-expressions among them: zero is false
        random = np.random.default_rng(20180602)
        conditions = [s.name() not in self._parameters and s.name() not in self._names for s in symbols]
        for _ in range(_TRIES if any(conditions) else 1):
            values = random.uniform(0.5, 1.5, len(symbols)) * (
                1 - np.array(conditions) * random.integers(0, 2, len(symbols))
            )
            matrix: npt.NDArray[np.float64] = function(values).full()
            if not np.isfinite(matrix).all() or has_full_rank(matrix, _SINGULAR):
                return
        rows, variables = dependent_rows(matrix, _SINGULAR), dependent_rows(matrix.T, _SINGULAR)
        raise Singular([equations[i] for i in rows], [columns[i] for i in variables])

    def _coupled(self, equations: list[int], columns: list[int], *, linear: bool) -> None:
        """Solve a block of coupled equations."""
        rest_equations, rest_columns, steps = self._causalize(equations, columns)
        if len(rest_equations) > CRAMER:
            nested = self._nested(equations, columns)
            if nested is not None:
                tear, residual, order = nested
                self._tear([tear], [residual], order, linear=linear)
                return
        self._tear(rest_columns, rest_equations, [([e], [j]) for e, j in steps], linear=linear)

    def _causalize(
        self, equations: list[int], columns: list[int]
    ) -> tuple[list[int], list[int], list[tuple[int, int]]]:
        """Peel off equations that give one unknown with a safe pivot; tear the most connected unknown when stuck.

        Returns the residual equations, the torn unknowns, and the (equation, unknown) pairs in between in order.
        """
        open_equations, open_columns = list(equations), set(columns)
        torn: list[int] = []
        steps: list[tuple[int, int]] = []
        while open_columns:
            for row in open_equations:
                left = [j for j in self._incidence[row] if j in open_columns]
                if len(left) == 1 and self._solvable(row, left[0]):
                    steps.append((row, left[0]))
                    open_equations.remove(row)
                    open_columns.discard(left[0])
                    break
            else:
                tear = self._most_connected(open_equations, open_columns)
                torn.append(tear)
                open_columns.discard(tear)
        return open_equations, torn, steps

    def _most_connected(self, equations: list[int], columns: set[int]) -> int:
        def weight(j: int) -> tuple[bool, int, int]:
            rows = [row for row in equations if j in self._incidence[row]]
            frees = sum(sum(k in columns for k in self._incidence[row]) == 2 for row in rows)
            return self._names[j] in self._tear_first, frees, len(rows)

        return max(sorted(columns), key=weight)

    def _nested(
        self, equations: list[int], columns: list[int]
    ) -> tuple[int, int, list[tuple[list[int], list[int]]]] | None:
        """One tearing variable whose removal leaves only small linear blocks with pivots known to be regular."""
        best: tuple[tuple[int, int], int, int, list[tuple[list[int], list[int]]]] | None = None
        for tear in (j for j in columns if self._names[j] in self._tear_first):
            rest = [j for j in columns if j != tear]
            position = {j: k for k, j in enumerate(rest)}
            for residual in equations:
                rows = [row for row in equations if row != residual]
                incidence = [[position[j] for j in self._incidence[row] if j in position] for row in rows]
                blocks = triangular(incidence, len(rest))
                if blocks is None:
                    continue
                order = [([rows[i] for i in es], [rest[k] for k in js]) for es, js in blocks]
                size = max(len(es) for es, _ in order), sum(len(es) ** 2 for es, _ in order)
                if (best is None or size < best[0]) and self._certified(order):
                    best = size, tear, residual, order
        return None if best is None else best[1:]

    def _certified(self, order: list[tuple[list[int], list[int]]]) -> bool:
        for equations, columns in order:
            if not self._linear(equations, columns):
                return False
            if len(equations) == 1 and self._solvable(equations[0], columns[0]):
                continue
            rest_equations, rest_columns, steps = self._causalize(equations, columns)
            if len(rest_columns) > CRAMER:
                return False
            if not self._is_regular(self._determinant(rest_equations, rest_columns, steps)):
                return False
        return True

    def _determinant(self, equations: list[int], columns: list[int], steps: list[tuple[int, int]]) -> SX:
        """Determinant of what is left of a linear system after the steps."""
        values: dict[str, SX] = {}
        for row, j in steps:
            values[self._names[j]] = substitute(self._explicit(row, j), values)
        unknown = ca.vertcat(*(self._unknowns[j] for j in columns))
        left = ca.vertcat(*(substitute(self._residuals[row], values) for row in equations))
        return _determinant(ca.densify(ca.jacobian(left, unknown)))

    def _tear(
        self, torn: list[int], residuals: list[int], order: list[tuple[list[int], list[int]]], *, linear: bool
    ) -> None:
        """Compute the rest of a block in terms of the torn unknowns, then these from the residual equations."""
        values: dict[str, SX] = {}
        inner: list[int] = []
        for equations, columns in order:
            if len(equations) == 1:
                values[self._names[columns[0]]] = substitute(self._explicit(equations[0], columns[0]), values)
            else:
                values |= self._cramer(equations, columns, values)
            inner += columns
        unknown = ca.vertcat(*(self._unknowns[j] for j in torn))
        left = ca.vertcat(*(substitute(self._residuals[row], values) for row in residuals))
        if linear and torn:
            matrix, constant = _affine(left, unknown)
            if len(torn) <= CRAMER:
                self._regular.append(_determinant(matrix))
            solution = solve_linear(matrix, -constant)
            for position, j in enumerate(torn):
                self._assign(j, solution[position])
        else:
            self._implicit(torn, left, unknown, residuals)
        for j in inner:
            # in terms of the torn unknowns, so that shared subexpressions stay shared
            self._assign(j, values[self._names[j]])

    def _implicit(self, torn: list[int], left: SX, unknown: SX, residuals: list[int]) -> None:
        if len(torn) <= CRAMER:
            self._regular.append(_determinant(ca.densify(ca.jacobian(left, unknown))))
        for j in torn:
            self.solution.torn.append(self._unknowns[j])
        self.solution.residuals += ca.vertsplit(left)
        self.solution.residual_equations += residuals

    def _cramer(self, equations: list[int], columns: list[int], values: dict[str, SX]) -> dict[str, SX]:
        """Solve a small certified linear block inside a torn one."""
        rest_equations, rest_columns, steps = self._causalize(equations, columns)
        found: dict[str, SX] = {}
        inside: dict[str, SX] = dict(values)
        for row, j in steps:
            inside[self._names[j]] = substitute(self._explicit(row, j), inside)
        unknown = ca.vertcat(*(self._unknowns[j] for j in rest_columns))
        left = ca.vertcat(*(substitute(self._residuals[row], inside) for row in rest_equations))
        matrix, constant = _affine(left, unknown)
        solution = solve_linear(matrix, -constant)
        for position, j in enumerate(rest_columns):
            found[self._names[j]] = solution[position]
        for _, j in steps:
            found[self._names[j]] = substitute(inside[self._names[j]], found)
        return found

    # single equations

    def _explicit(self, row: int, j: int) -> SX:
        """The unknown of an equation that is linear in it."""
        symbol = self._unknowns[j]
        coefficient = ca.jacobian(self._residuals[row], symbol)
        return -ca.substitute(self._residuals[row], symbol, 0) / coefficient

    def _coefficient(self, row: int, j: int) -> SX:
        return substitute(ca.jacobian(self._residuals[row], self._unknowns[j]), self._full)

    def _solvable(self, row: int, j: int) -> bool:
        """Linear in the unknown, with a coefficient that may be divided by."""
        coefficient = ca.jacobian(self._residuals[row], self._unknowns[j])
        return not depends(coefficient, self._unknowns[j]) and self._is_safe(coefficient)

    def _is_safe(self, coefficient: SX) -> bool:
        symbols = ca.symvar(coefficient)
        if any(s.name() not in self._parameters for s in symbols):
            return False
        return abs(float(evaluate(coefficient, self._parameters))) > 0.0

    def _linear(self, equations: list[int], columns: list[int]) -> bool:
        unknown = ca.vertcat(*(self._unknowns[j] for j in columns))
        jacobian = ca.jacobian(ca.vertcat(*(self._residuals[row] for row in equations)), unknown)
        return not depends(jacobian, unknown)

    # what is known

    def _assign(self, j: int, value: SX) -> None:
        self.solution.steps.append((self._unknowns[j], value))
        self._full[self._names[j]] = substitute(value, self._full)

    def _is_regular(self, pivot: SX) -> bool:
        """Whether a pivot is safe, or proportional to one the whole system needs to be nonzero.

        Proportional means: their ratio is the same number at several random points. Parameters keep their default
        values there, so a factor of parameters is part of the ratio.
        """
        if self._is_safe(pivot):
            return True
        values = self._at_points(substitute(pivot, self._full))
        for known in self._regular:
            ratio = values / self._at_points(substitute(known, self._full))
            if np.isfinite(ratio).all() and np.ptp(ratio) <= 1e-9 * np.abs(ratio).max() and np.abs(ratio).max() > 0:
                return True
        return False

    def _at_points(self, expression: SX) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        symbols = ca.symvar(expression)
        function = ca.Function("value", [ca.vertcat(SX(0, 1), *symbols)], [expression])
        points = [[self._value(point, s.name()) for s in symbols] for point in self._points]
        return np.array([float(function(point)) for point in points])

    def _value(self, point: dict[str, float], name: str) -> float:
        if name in self._parameters:
            return self._parameters[name]
        if name not in point:
            point[name] = float(self._random.uniform(0.5, 1.5))
        return point[name]


def _affine(left: SX, unknown: SX) -> tuple[SX, SX]:
    """(A, b) of an expression A unknown + b."""
    return ca.densify(ca.jacobian(left, unknown)), ca.substitute(left, unknown, ca.DM.zeros(unknown.numel()))


def _determinant(matrix: SX) -> SX:
    """Determinant by expansion; for the small systems only."""
    n = matrix.shape[0]
    if n == 0:
        return SX(1.0)
    if n == 1:
        return matrix[0, 0]
    total = SX(0.0)
    for j in range(n):
        if matrix[0, j].is_zero():
            continue
        rest = [k for k in range(n) if k != j]
        minor = _determinant(matrix[list(range(1, n)), rest])
        total += matrix[0, j] * minor * (-1.0 if j % 2 else 1.0)
    return total


def solve_linear(matrix: SX, right: SX) -> SX:
    """The solution of ``matrix @ x = right``: by Cramer's rule up to three unknowns, else by a QR factorisation."""
    n = matrix.shape[0]
    if n > CRAMER:
        return ca.solve(matrix, right)
    determinant = _determinant(matrix)
    columns = []
    for j in range(n):
        replaced = SX(matrix)
        replaced[:, j] = right
        columns.append(_determinant(replaced) / determinant)
    return ca.vertcat(*columns)

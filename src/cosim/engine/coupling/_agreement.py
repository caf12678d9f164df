"""Repeats a macro step until the components agree at its end, with the ends of the links as the unknowns.

Of these, those of the links against the order of the steps are iterated: first each becomes what its source has given;
if that does not contract, by Newton's method, with the matrix measured by one step for each link, kept from then on,
and mended after each step as Broyden does (Math. Comp. 19, 1965, p. 577). That takes nothing of the FMUs but that they
can go back to a state, and it finds solutions that repetition alone runs away from: loops of gain above 1.
"""

from __future__ import annotations

from array import array

from cosim.engine.algebra._algebraic import LoopError
from cosim.engine.coupling._coupling import INNER, Coupling

MOST_PASSES = 40
CONTRACTS = 0.3
"""Repetition alone is given up if it does not make the difference smaller by this factor."""
ACCURACY = 0.01
"""Of the agreement, relative to the tolerance."""
_PROBE = 1e-4
"""By which a value is changed to see what comes of it, relative to its scale."""
_SINGULAR = 1e-10
_GAIN_1 = 1e-7
"""Pivot below which a change comes back around a loop unchanged, as far as can be seen."""


def agree(coupling: Coupling, t: float, h: float, recording: bool) -> None:
    """Step from t over h [s], from ends that are predicted already; raises CallError if no agreement is found."""
    n = len(coupling.cut)
    coupling.save(INNER)
    residual, change = array("d", bytes(8 * n)), array("d", bytes(8 * n))
    last = 0.0
    measured = False
    for passes in range(MOST_PASSES):
        coupling.take(t, h, recording)
        norm = _residual(coupling, residual)
        if norm <= 1.0:
            return
        if passes > 0 and coupling.has_matrix:
            mend(coupling.matrix, residual, change)
        if passes > 0 and not norm <= CONTRACTS * last and not measured:
            _measure(coupling, t, h, residual)
            measured = True
        last = norm
        if not coupling.has_matrix:
            change[:] = residual
        elif not solve(coupling.matrix, residual, change):
            break
        coupling.restore(INNER)
        coupling.repeated += 1
        for k, i in enumerate(coupling.cut):
            coupling.end[i] += change[k]
    raise disagreement(coupling, t + h)


def _residual(coupling: Coupling, residual: array[float]) -> float:
    """Put the differences between what the sources give and what was taken; return the largest over what is allowed."""
    norm = 0.0
    for k, i in enumerate(coupling.cut):
        residual[k] = coupling.links[i].of(coupling.values) - coupling.end[i]
        allowed = ACCURACY * coupling.tolerance * max(coupling.scale[i], abs(coupling.end[i]))
        ratio = abs(residual[k]) / allowed
        norm = ratio if not ratio <= norm else norm
    return norm


def _measure(coupling: Coupling, t: float, h: float, residual: array[float]) -> None:
    """Find the matrix, that of the residuals' negative derivatives, by one step for each of its columns."""
    n = len(coupling.cut)
    probed = array("d", bytes(8 * n))
    ends = coupling.end[:]
    for column, i in enumerate(coupling.cut):
        coupling.restore(INNER)
        coupling.repeated += 1
        memoryview(coupling.end)[:] = memoryview(ends)
        probe = _PROBE * max(coupling.scale[i], abs(ends[i]))
        coupling.end[i] += probe
        coupling.take(t, h, recording=False)
        _residual(coupling, probed)
        for row in range(n):
            coupling.matrix[row * n + column] = (residual[row] - probed[row]) / probe
    memoryview(coupling.end)[:] = memoryview(ends)
    coupling.has_matrix = True


def mend(matrix: array[float], residual: array[float], change: array[float]) -> None:
    """Let the matrix explain what has become of the residuals after a change of the unknowns that it asked for."""
    n = len(change)
    square = 0.0
    for x in change:
        square += x * x
    if square > 0.0:
        for row in range(n):
            for column in range(n):
                matrix[row * n + column] -= residual[row] * change[column] / square


def solve(matrix: array[float], right: array[float], solution: array[float]) -> bool:
    """Solve by elimination with row pivoting; return False if the matrix is singular or has lost its numbers."""
    n = len(right)
    a = array("d", matrix)
    solution[:] = right
    for k in range(n):
        pivot, best, size = k, abs(a[k * n + k]), 0.0
        for row in range(k, n):
            if abs(a[row * n + k]) > best:
                pivot, best = row, abs(a[row * n + k])
        for column in range(n):
            size = max(size, abs(matrix[pivot * n + column]))
        if not best > max(_SINGULAR * size, _GAIN_1 if pivot == k else 0.0):
            return False
        if pivot != k:
            for column in range(n):
                a[k * n + column], a[pivot * n + column] = a[pivot * n + column], a[k * n + column]
            solution[k], solution[pivot] = solution[pivot], solution[k]
        for row in range(k + 1, n):
            factor = a[row * n + k] / a[k * n + k]
            for column in range(k, n):
                a[row * n + column] -= factor * a[k * n + column]
            solution[row] -= factor * solution[k]
    for k in range(n - 1, -1, -1):
        for column in range(k + 1, n):
            solution[k] -= a[k * n + column] * solution[column]
        solution[k] /= a[k * n + k]
    return True


def disagreement(coupling: Coupling, t: float) -> LoopError:
    """Return the error for components that do not come to agree at the end of a step, at t [s]."""
    members = {i: member.participant.instance for member in coupling.members for i in member.links}
    parts = []
    for i in coupling.cut:
        link, instance = coupling.links[i], members[i]
        taken, given = coupling.end[i], link.of(coupling.values)
        unit = instance.fmu.variables[link.name.removeprefix(f"{instance.name}.")].unit
        u = "" if unit in (None, "1") else f" {unit}"
        parts.append(f"{link.name} = {taken:.9g}{u} comes back as {given:.9g}{u} (residual {given - taken:.3g}{u})")
    what = "at which the components agree"
    if coupling.method.loops:
        what = f"that fulfil the algebraic loop {' and '.join(coupling.method.loops)}"
    return LoopError(
        members[coupling.cut[0]],
        f"in the step to {t:.9g} s no values are found {what}: {'; '.join(parts)}",
        "see whether there is a solution; take shorter steps, or break the loop by a state, a sample or a delay",
    )

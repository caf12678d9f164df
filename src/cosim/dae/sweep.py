"""One Newton sweep over the torn unknowns as a closed expression, where their blocks are small enough for that."""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from cosim.dae.blocks import triangular
from cosim.dae.hybrid import SX
from cosim.dae.tearing import CRAMER, solve_linear


def newton_sweep(residuals: SX, unknowns: Sequence[SX]) -> SX | None:
    """The unknowns after one Newton step for each block, taken in the order of computation.

    A block sees the blocks before it as they are after their steps, so that the sweep converges as Newton's method
    does for the whole system, without the derivatives of one block by the unknowns of another.

    Args:
        residuals: as many as unknowns.
        unknowns: their symbols.

    Returns:
        A column as long as ``unknowns``, or None if a block is too large for Cramer's rule. Where a block is singular,
        its entries are not finite.
    """
    z = ca.vertcat(SX(0, 1), *unknowns)
    jacobian = ca.jacobian(residuals, z)
    pattern = jacobian.sparsity()
    incidence = [[j for j in range(len(unknowns)) if pattern.has_nz(i, j)] for i in range(len(unknowns))]
    blocks = triangular(incidence, len(unknowns))
    if blocks is None or any(len(rows) > CRAMER for rows, _ in blocks):
        return None
    swept = SX(z)
    for rows, columns in blocks:
        r, matrix = ca.substitute([residuals[rows], ca.densify(jacobian[rows, columns])], [z], [swept])
        swept[columns] += solve_linear(matrix, -r)
    return swept

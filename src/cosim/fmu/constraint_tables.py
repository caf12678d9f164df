"""The C tables of the constraints that a choice of states rests on; ``runtime/selection.c`` reads them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import casadi as ca

from cosim.dae.constraints import Constraints
from cosim.dae.hybrid import SX


class Table(NamedTuple):
    """A constant array; name and size are those of ``model.h`` after ``model_`` and ``MODEL_``."""

    kind: str
    name: str
    size: str
    values: list[str]
    """C text; for strings, what has to be put in quotes."""


def constraint_sizes(constraints: Sequence[Constraints]) -> dict[str, int]:
    """The sizes of the tables, by the names they have in ``model_sizes.h`` after ``MODEL_``."""
    shapes = [c.jacobian.shape for c in constraints]
    return {
        "NCONSTRAINTS": len(constraints),
        "CONSTRAINT_ROWS": sum(rows for rows, _ in shapes),
        "CONSTRAINT_COLUMNS": sum(columns for _, columns in shapes),
        "CONSTRAINT_ENTRIES": sum(c.jacobian.nnz() for c in constraints),
        "CONSTRAINT_ROOM": max((rows * columns for rows, columns in shapes), default=0),
    }


def constraint_tables(constraints: Sequence[Constraints]) -> tuple[list[Table], SX]:
    """The tables, and the entries of all matrices as one column."""
    places = [c.jacobian.sparsity().get_triplet() for c in constraints]
    shapes = [(*c.jacobian.shape, c.jacobian.nnz()) for c in constraints]
    tables = [
        Table("ModelConstraints", "constraints", "NCONSTRAINTS", [f"{{{r}, {c}, {n}}}" for r, c, n in shapes]),
        Table("unsigned short", "constraint_row", "CONSTRAINT_ENTRIES", [str(i) for rows, _ in places for i in rows]),
        Table("unsigned short", "constraint_column", "CONSTRAINT_ENTRIES",
              [str(j) for _, columns in places for j in columns]),
        Table("unsigned short", "constraint_block", "CONSTRAINT_ROWS", [str(b) for c in constraints for b in c.blocks]),
        Table("char *const", "constraint_texts", "CONSTRAINT_ROWS", [e for c in constraints for e in c.equations]),
        Table("char *const", "constraint_variables", "CONSTRAINT_COLUMNS",
              [name for c in constraints for name in c.variables]),
    ]  # fmt: skip
    return tables, ca.vertcat(SX(0, 1), *(ca.vec(c.jacobian).nz[:] for c in constraints))

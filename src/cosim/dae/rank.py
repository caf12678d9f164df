"""Which rows of a matrix of numbers depend on each other."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Matrix = npt.NDArray[np.float64]


def has_full_rank(matrix: Matrix, tolerance: float) -> bool:
    """Whether the rows are linearly independent, each taken relative to its own size."""
    size = np.linalg.norm(matrix, axis=1, keepdims=True)
    if not len(matrix):
        return True
    return bool(np.linalg.matrix_rank(matrix / np.where(size > 0, size, 1.0), tolerance) == len(matrix))


def dependent_rows(matrix: Matrix, tolerance: float) -> list[int]:
    """A smallest set of rows that are linearly dependent; all rows if none are."""
    kept = list(range(len(matrix)))
    for row in range(len(matrix)):
        rest = [i for i in kept if i != row]
        if not has_full_rank(matrix[rest], tolerance):
            kept = rest
    return kept

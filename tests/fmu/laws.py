"""Closed forms that the tests of several models use."""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm

G = 9.81


def linear(A: np.ndarray, b: np.ndarray, x0: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Solution of dx/dt = A x + b at the times, by the matrix exponential of the system with b as one more state."""
    n = len(x0)
    whole = np.zeros((n + 1, n + 1))
    whole[:n, :n], whole[:n, n] = A, b
    return np.array([(expm(whole * t) @ np.append(x0, 1.0))[:n] for t in times])

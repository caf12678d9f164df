"""How the progress of a fit is told."""

from collections.abc import Callable

Progress = Callable[[int, float], None]
"""Is told the number of the iteration, and the root of the mean square of the residuals over their noise."""

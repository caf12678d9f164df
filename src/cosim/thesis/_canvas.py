"""What all pictures have in common: colours, axes, legend below, and how they are written."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# the lines differ in style or place besides
GREY = "#999999"


def canvas(title: str, *, rows: int = 1, columns: int = 1, size: tuple[float, float] = (9.0, 4.5)) -> tuple[
    Figure, list[Axes]
]:  # fmt: skip
    """Return an empty figure and its axes, row by row; ``size`` in inches of 110 pixels."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, dpi=110, layout="constrained")
    if rows * columns > 1:
        figure.suptitle(title, fontsize=12)
    axes = [figure.add_subplot(rows, columns, k + 1) for k in range(rows * columns)]
    for axis in axes:
        axis.grid(alpha=0.25)
    if rows * columns == 1:
        axes[0].set_title(title, fontsize=12)
    return figure, axes


def legend(axes: Axes, handles: Sequence[Artist] | None = None, columns: int = 5) -> None:
    """Put the legend below the axes; without ``handles`` that of all lines."""
    shown = axes.get_lines() if handles is None else handles
    axes.legend(
        handles=shown, loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=columns, fontsize=8, frameon=False
    )


def save(figure: Figure, path: Path) -> None:
    """Write a PNG file."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    # unlike savefig, which draws once more to measure, this draws once
    FigureCanvasAgg(figure).print_png(str(path), pil_kwargs={"compress_level": 1})  # type: ignore[no-untyped-call]

"""The study in one picture: margins and verdicts of each open choice alone, effects and verdicts of all together."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cosim.colours import BLUE, GREEN, ORANGE, PINK, RED
from cosim.thesis._canvas import GREY, save
from cosim.thesis._runs import SAMPLE_TIMES
from cosim.thesis._sensitivity import Responses, Study
from cosim.thesis._sensitivity_factors import FACTORS
from cosim.thesis._sensitivity_runs import LOADS, READINGS, Table
from cosim.thesis._sensitivity_verdict import Verdict, judge_table, park_share

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Okabe and Ito's colours; each verdict has a letter and each sampling time a marker besides.
COLOURS = {
    Verdict.BEST: BLUE,
    Verdict.SHARED: "#56B4E9",
    Verdict.SAME: "#DDDDDD",
    Verdict.SHORTER: ORANGE,
    Verdict.LONGER: RED,
    Verdict.LATE: "#555555",
}
LETTERS = {
    Verdict.BEST: "B", Verdict.SHARED: "b", Verdict.SAME: "=", Verdict.SHORTER: "<", Verdict.LONGER: ">",
    Verdict.LATE: "L",
}  # fmt: skip
MARKS = dict(zip(SAMPLE_TIMES, (("o", GREY), ("s", GREEN), ("^", PINK), ("D", BLUE), ("v", RED)), strict=True))
LEADS = (-160.0, 260.0)
"""Leads that are shown [ms]; what lies beyond is drawn at the edge."""
SHOWN = "dip"
"""Reading whose parks are shown: as a plot shows them."""
_DARK = (Verdict.BEST, Verdict.LONGER, Verdict.LATE)


def draw(study: Study, path: Path) -> None:
    """Write the picture as a PNG file."""
    from matplotlib.figure import Figure

    tables = study.of("alone", "together")
    figure = Figure(figsize=(13.0, 14.0), dpi=100, layout="constrained")
    figure.suptitle("Table 4.1 under other open choices: the rig, both loads", fontsize=13)
    halves = figure.add_gridspec(2, 1, height_ratios=(1.0, 0.45))
    upper, lower = figure.add_subfigure(halves[0]), figure.add_subfigure(halves[1])
    leads, parks, verdicts = upper.subplots(1, 3, sharey=True, width_ratios=(2.3, 1.0, 1.1))
    _leads(leads, tables)
    _parks(parks, tables)
    _verdicts(verdicts, tables)
    ahead, passed, shares = lower.subplots(1, 3, width_ratios=(1.0, 1.0, 1.1))
    _effects(ahead, study.advantages, study.ranking)
    ahead.set_title("effect on the advantage of 20 ms\nover the best other one", fontsize=10)
    ahead.set_xlabel(
        "points of a hundred; mean and range of the\nreadings; grey: scatter; right: part in the variation"
    )
    _effects(passed, study.passes, study.ranking)
    passed.set_title("effect on the predictions passed,\nall sampling times", fontsize=10)
    passed.set_xlabel("points of a hundred")
    passed.set_yticklabels([])
    _shares(shares, study)
    lower.legend(*shares.get_legend_handles_labels(), fontsize=8, loc="outside lower center", ncols=3, frameon=False)
    save(figure, path)


def _leads(axes: Axes, tables: Sequence[Table]) -> None:
    from matplotlib.patches import Rectangle

    for row, table in enumerate(tables):
        setting = table.case.setting
        stop = 1e3 * float(setting["soft_stop"]) * float(setting["T_ramp_s"])
        axes.add_patch(Rectangle((-stop, row - 0.5), stop, 1.0, facecolor="#FFE9B0", edgecolor="none", zorder=0))
        for place, (time, (marker, colour)) in enumerate(MARKS.items()):
            leads = 1e3 * np.array([lead for load in LOADS for lead in table.outcomes[time, load].leads])
            if not len(leads):
                continue
            height = row + 0.16 * (place - 2)
            shown = np.clip(leads, *LEADS)
            axes.plot([shown.min(), shown.max()], [height, height], color=colour, linewidth=0.7, zorder=1)
            middle = float(np.clip(np.median(leads), *LEADS))
            label = f"{1e3 * time:.0f} ms" if row == 0 else None
            axes.plot(middle, height, marker=marker, color=colour, markersize=4.5, linestyle="none", label=label)
    axes.axvline(0, color="black", linewidth=0.8)
    axes.axvline(100, color="black", linewidth=0.8, linestyle=":")
    axes.set(xlim=LEADS, ylim=(len(tables) - 0.5, -0.5))
    axes.set_xlabel(
        "from the end of the planned deceleration to the park signal [ms]\nmedian and range; > 0: too early"
    )
    axes.set_yticks(range(len(tables)), [table.case.name for table in tables], fontsize=8)
    for row in range(len(tables) - 1):
        axes.axhline(row + 0.5, color="white" if row else "black", linewidth=0.6)
    axes.axhline(len([t for t in tables if t.case.design == "alone"]) - 0.5, color="black", linewidth=0.6)
    axes.set_title("park margin (yellow: decelerating at the signal)", fontsize=10)
    axes.legend(
        title="sampling time",
        fontsize=8,
        title_fontsize=8,
        loc="center right",
        bbox_to_anchor=(1.0, 0.36),
        framealpha=0.9,
    )
    axes.grid(axis="x", alpha=0.25)


def _parks(axes: Axes, tables: Sequence[Table]) -> None:
    reading = next(reading for reading in READINGS if reading.key == SHOWN)
    shares = np.array([[100 * park_share(table, reading, time) for time in SAMPLE_TIMES] for table in tables])
    axes.imshow(shares, cmap="cividis", vmin=0, vmax=100, aspect="auto")
    for (row, column), share in np.ndenumerate(shares):
        colour = "white" if share < 55 else "black"
        axes.text(column, row, f"{share:.0f}", ha="center", va="center", fontsize=8, color=colour)
    axes.set_xticks(range(len(SAMPLE_TIMES)), [f"{1e3 * time:.0f}" for time in SAMPLE_TIMES])
    axes.set_xlabel("sampling time [ms]")
    axes.set_title(f"parks predicted [%]\n(up to 0.1 s early: {reading.key})", fontsize=10)
    axes.tick_params(axis="y", length=0)


def _verdicts(axes: Axes, tables: Sequence[Table]) -> None:
    from matplotlib.patches import Rectangle

    for row, table in enumerate(tables):
        for column, reading in enumerate(READINGS):
            found = judge_table(table, reading)
            axes.add_patch(Rectangle((column - 0.5, row - 0.5), 1, 1, facecolor=COLOURS[found], edgecolor="white"))
            colour = "white" if found in _DARK else "black"
            axes.text(column, row, LETTERS[found], ha="center", va="center", fontsize=8, color=colour)
    axes.set(xlim=(-0.5, len(READINGS) - 0.5))
    axes.set_xticks(range(len(READINGS)), [reading.key for reading in READINGS], rotation=60, ha="right", fontsize=8)
    axes.set_title("verdict on 20 ms, by reading\n(letters as below)", fontsize=10)
    axes.tick_params(axis="y", length=0)


def _effects(axes: Axes, responses: Responses, order: Sequence[int]) -> None:
    effects, mean = 100 * responses.main, 100 * responses.mean
    rows = np.arange(len(order))
    axes.axvspan(-100 * responses.margin, 100 * responses.margin, color="#EEEEEE", zorder=0)
    axes.barh(rows, mean[order], height=0.6, color=BLUE)
    axes.hlines(rows, effects.min(axis=0)[order], effects.max(axis=0)[order], color="black", linewidth=1.2)
    edge = max(abs(value) for value in axes.get_xlim())
    for row, k in enumerate(order):
        axes.text(1.55 * edge, row, f"{100 * responses.parts[k]:.0f} %", ha="right", va="center", fontsize=8)
    labels = [
        f"{FACTORS[k].label}: {FACTORS[k].format(FACTORS[k].low)} → {FACTORS[k].format(FACTORS[k].high)}" for k in order
    ]
    axes.set_yticks(rows, labels, fontsize=8)
    axes.set(xlim=(-edge, 1.6 * edge), ylim=(len(order) - 0.5, -0.5))
    axes.axvline(0, color="black", linewidth=0.8)
    axes.grid(axis="x", alpha=0.25)


def _shares(axes: Axes, study: Study) -> None:
    rows = np.arange(len(READINGS))
    left = np.zeros(len(READINGS))
    for verdict in Verdict:
        number = np.array([study.verdicts[reading.key].count(verdict) for reading in READINGS])
        label = f"{LETTERS[verdict]}  {verdict.value}"
        axes.barh(rows, number, left=left, height=0.7, color=COLOURS[verdict], edgecolor="white", label=label)
        for row in rows[number > 1]:
            colour = "white" if verdict in _DARK else "black"
            axes.text(left[row] + number[row] / 2, row, number[row], ha="center", va="center", fontsize=8, color=colour)
        left += number
    axes.set_yticks(rows, [reading.key for reading in READINGS], fontsize=8)
    axes.set(xlim=(0, len(study.of("factorial"))), xlabel="settings of the two-level fraction")
    axes.invert_yaxis()
    axes.set_title("verdicts on 20 ms,\nall combinations", fontsize=10)

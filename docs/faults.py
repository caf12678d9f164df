"""Writes docs/faults.md and its pictures: the wiper's controller with a stuck contact, a noisy and a late current.

Run with ``python docs/faults.py`` from a checkout.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from textwrap import fill

import numpy as np
from numpy.typing import NDArray

from cosim.assessment import Revolution, Rules, Score, score
from cosim.colours import BLACK, BLUE, GREEN, RED
from cosim.engine import Fault, Result, System, simulate
from cosim.fmu import catalogue
from cosim.scenario import Scenario, assemble, read

ROOT = Path(__file__).parents[1]
PICTURES = ROOT / "docs" / "pictures" / "faults"
RULES = Rules(early=0.1, repeats="separate")
RIG, WIPER = "rig_20ms", "linkage_20ms"
SCENARIOS = ("rig_20ms", "rig_park_stuck_open", "rig_park_stuck_closed", "rig_noisy_current", "rig_late_current")
STUCK = (7.0, 15.0)
NO_STOP = 1.5
"""A stop so long before a closing [s] is that of an earlier revolution."""
DELAYS = (1, 2, 5, 10, 20, 40, 60, 80, 100, 150, 200, 250, 300, 350, 400, 500, 600, 700, 800)
"""[ms]"""
SIGMAS = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
"""[A]"""
SEEDS = range(1, 21)
CURRENT = ("controller", "i_motor")
PLANTS = {RIG: ("rig, mean of 125 ms", BLUE, "o"), WIPER: ("linkage, no mean", RED, "s")}


@dataclass(frozen=True)
class Run:
    """A run and what the thesis's criteria say of it."""

    result: Result
    score: Score

    @property
    def counts(self) -> tuple[str, str]:
        """Parks predicted and turns, each of how many; without the first revolution, before which none is measured."""
        counts = self.score.counts_without_first
        return f"{counts.park_deceleration}/{counts.park_total}", f"{counts.turn}/{counts.turn_total}"

    @cached_property
    def decisions(self) -> list[tuple[float, str]]:
        """When the chart enters a state [s], and which."""
        states = self.result.columns["controller.state"]
        names = self.result.literals["controller.state"]
        rows = np.flatnonzero(np.diff(states)) + 1
        return [(round(float(self.result.time[row]), 6), names[states[row] - 1]) for row in rows]

    @property
    def leads(self) -> list[tuple[float, float]]:
        """When the contact closes [s], and how long before it the last Soft_stop that was planned ended [s]."""
        park = self.result.columns["plant.park"]
        closings = self.result.time[1:][np.diff(park) > 0].tolist()
        entries = self.decisions
        stays = [(t, t2) for (t, state), (t2, _) in pairwise(entries) if state == "Soft_stop"]
        ends = [end for start, end in stays if not any(abs(start - closing) < 1.5e-3 for closing in closings)]
        return [(at, at - max((end for end in ends if end < at + 0.051), default=np.nan)) for at in closings]

    @property
    def revolutions(self) -> tuple[Revolution, ...]:
        """All revolutions but the first."""
        return self.score.revolutions[1:]

    @property
    def turns(self) -> list[float]:
        """Where the chart turns, as shares of the revolution from park to park."""
        return [r.turn_position for r in self.revolutions if r.turn_position is not None]


@dataclass(frozen=True)
class Bench:
    """A scenario, loaded once for many runs."""

    scenario: Scenario
    system: System

    @classmethod
    def load(cls, name: str) -> Bench:
        """Take one of the folder ``scenarios``."""
        scenario = read(ROOT / "scenarios" / f"{name}.csv")
        return cls(scenario, assemble(scenario, catalogue.ensure))

    def run(self, *faults: Fault) -> Run:
        """Run it, with these faults beside its own."""
        system = replace(self.system, faults=[*self.system.faults, *faults])
        result = simulate(
            system,
            stop=self.scenario.stop,
            output_interval=self.scenario.output_interval,
            tolerance=self.scenario.tolerance,
        )
        return Run(result, score(result, RULES))


def shipped() -> dict[str, Run]:
    """Run the scenarios of the study."""
    return {name: Bench.load(name).run() for name in SCENARIOS}


@dataclass(frozen=True)
class Sweep:
    """One plant with a late and with a noisy current; the healthy run first."""

    healthy: Run
    late: dict[int, Run]
    """By the delay [ms]."""
    noisy: dict[float, list[Run]]
    """By the standard deviation [A], one for each seed."""
    first_other: int
    """Least delay in whole milliseconds that changes a decision."""

    @property
    def most_in_place(self) -> int:
        """The longest delay tried [ms] with which all turns are within `Rules.position` of their healthy place."""
        usual = float(np.median(self.healthy.turns))
        far = [ms for ms, run in self.late.items() if max(abs(x - usual) for x in run.turns) > RULES.position]
        return max(ms for ms in self.late if ms < min(far, default=10**9))


def sweep(name: str) -> Sweep:
    """Try all delays and all noises on one plant."""
    bench = Bench.load(name)
    healthy = bench.run()
    first = next(
        ms for ms in range(1, 100) if bench.run(Fault(CURRENT, "delay", 1e-3 * ms)).decisions != healthy.decisions
    )
    return Sweep(
        healthy,
        {ms: bench.run(Fault(CURRENT, "delay", 1e-3 * ms)) for ms in DELAYS},
        {sigma: [bench.run(Fault(CURRENT, "noise", sigma, seed=seed)) for seed in SEEDS] for sigma in SIGMAS},
        first,
    )


def drift(run: Run) -> list[float]:
    """Return by how much the lead grows from one closing to the next while the contact is stuck [s]."""
    leads = [lead for at, lead in run.leads if STUCK[0] < at < STUCK[1] + 1.0]
    return [b - a for a, b in pairwise(leads)]


def stuck_section(runs: dict[str, Run]) -> str:
    """Return the part of the page on the contact, which needs the shipped scenarios alone."""
    rows = "\n".join(_row(name, run) for name, run in runs.items())
    opened, closed = runs["rig_park_stuck_open"], runs["rig_park_stuck_closed"]
    growth = 1e3 * float(np.mean(drift(opened)))
    periods = [max(run.result.columns["controller.period"]) for run in (opened, closed)]
    away = [r.number for r in closed.score.revolutions if STUCK[0] < r.end < STUCK[1] + 1.0 and not r.turn]
    leads = "\n".join(
        f"| {at:.2f} | " + " | ".join(_lead(run, number) for run in _contacts(runs)) + " |"
        for number, (at, _) in enumerate(runs[RIG].leads[2:10], 2)
    )
    return f"""| scenario | fault | parks predicted | turns | place of the turns (median) |
|---|---|---|---|---|
{rows}

## A park contact that is stuck

The contact tells the chart when a revolution has ended, and how long it was. Of a revolution of two periods the chart
plans all but half a ramp: it ends each one {1e3 * 0.05:.0f} ms less a tick too early, which the next closing puts right
once it is 0.15 s. Without the contact nothing does.

| contact closes, healthy [s] | healthy: lead [ms] | stuck open: lead [ms] | stuck closed: lead [ms] |
|---|---|---|---|
{leads}

The lead is the time from the end of the planned Soft_stop to the closing of the real contact.

![Lead of each revolution, healthy and with the contact stuck open and closed](pictures/faults/contact.png)

* **Stuck open** from {STUCK[0]:g} s to {STUCK[1]:g} s: the lead grows by {growth:.0f} ms a revolution. All turns stay
  in place, as the period is still right, but no park is predicted any more: the wiper would be slowed down a quarter of
  a revolution early after {0.5 / (1e-3 * growth):.0f} revolutions.
* **Stuck closed**: the rising edge at {STUCK[0]:g} s, in the middle of a revolution, counts as the park position. From
  then on the profile stops softly where it should turn, and turns near the park position: {_turns_text(away)}.
* **The contact comes back** at {STUCK[1]:g} s, and the first edge makes one period of the whole time in between:
  {periods[0]:.2f} s and {periods[1]:.2f} s in the place of 1.00 s. That costs one turn in each case. The next edge
  measures a revolution again, or, stuck closed, half of one and a turn too many; the second is right.
* **What gives it away**: these periods are more than {min(periods):.0f} times the one before. In the healthy run the
  period never differs by more than {100 * _jump(runs[RIG]):.1f} % from the one before.
"""


def _contacts(runs: dict[str, Run]) -> Sequence[Run]:
    return [runs[name] for name in SCENARIOS[:3]]


def _turns_text(away: list[int]) -> str:
    return f"revolutions {', '.join(map(str, away))} have no turn in its place"


def _lead(run: Run, number: int) -> str:
    lead = run.leads[number][1]
    return f"{1e3 * lead:.0f}" if lead < NO_STOP else "no stop"


def _row(name: str, run: Run) -> str:
    faults = read(ROOT / "scenarios" / f"{name}.csv").faults
    text = (ROOT / "scenarios" / f"{name}.csv").read_text(encoding="utf-8")
    words = [line.removeprefix("# fault: ") for line in text.splitlines() if line.startswith("# fault: ")]
    park, turn = run.counts
    shown = f"`{'`, `'.join(words)}`" if faults else "none"
    return f"| [{name}](../scenarios/{name}.csv) | {shown} | {park} | {turn} | {np.median(run.turns):.3f} |"


def page(runs: dict[str, Run], sweeps: dict[str, Sweep]) -> str:
    """Return docs/faults.md."""
    rig, wiper = sweeps[RIG], sweeps[WIPER]
    rate = _slope(rig)
    delays = "\n".join(
        f"| {ms} | "
        + " | ".join(f"{np.median(s.late[ms].turns):.3f} | {' | '.join(s.late[ms].counts)}" for s in (rig, wiper))
        + " |"
        for ms in DELAYS
        if ms in (5, 20, 60, 100, 200, 300, 400, 600, 800)
    )
    noises = "\n".join(
        f"| {sigma:g} | " + " | ".join(_noise_cells(s, sigma) for s in (rig, wiper)) + " |" for sigma in SIGMAS
    )
    return f"""# Faults at the controller's inputs

What the voltage profile does if its park contact is stuck, or its current is noisy or late: faults of the scenario
format ([docs/scenarios.md](scenarios.md#faults)), in runs of 25 s. `python docs/faults.py` makes this page.

The parks and turns of the first 20 s are counted as in [docs/scoring.md](scoring.md) (`early=100 ms`,
`repeats=separate`: a deceleration counts that ended up to 0.1 s before the contact closes), without the first
revolution, before which no period is measured. The rig has the moving average of
chapter 4, 125 ms; the linkage has none. All numbers are those of this model, whose parameters are partly assumed.

{stuck_section(runs)}
## A current that is late

The current has one part only: once half a period has passed, the chart turns as soon as the current falls below the
limit. So a delay moves the turn, and nothing else.

| delay [ms] | rig: place of the turns | parks | turns | linkage: place of the turns | parks | turns |
|---|---|---|---|---|---|---|
| 0 | {_healthy_cells(rig)} | {_healthy_cells(wiper)} |
{delays}

![Place of the turns over the delay](pictures/faults/delay.png)

* The current is looked at every 20 ms. The first delay that changes a decision is {rig.first_other} ms on the rig and
  {wiper.first_other} ms on the linkage: where the current happens to cross the limit just before it is looked at.
* Up to 0.4 s the turn of the rig moves by {rate:.2f} revolutions per second of delay, with the speed of the crank there
  ({_speed(rig):.2f} revolutions per second in the mean of a revolution).
* All turns are within {RULES.position:g} of a revolution of their healthy place up to {rig.most_in_place} ms on the rig
  and {wiper.most_in_place} ms on the linkage. The parks are predicted as before: {_parks_text(rig)} on the rig,
  {_parks_text(wiper)} on the linkage, over all delays up to 0.4 s.
* A delay of most of a revolution shows the chart the low current of the turn before: it turns too early, at
  {np.median(rig.late[800].turns):.2f} on the rig with 800 ms.

## A current that is noisy

Normal noise, a new number in each millisecond, {len(SEEDS)} seeds. Of the noise the mean of 125 values leaves
1/11; without it the window of the last second takes the least of 50 noisy samples, and the limit sinks to what the
motor takes without load.

| deviation [A] | rig: places of turns | missed or out of place | linkage: places of turns | missed or out of place |
|---|---|---|---|---|
{noises}

![Place of the turns over the noise](pictures/faults/noise.png)

* The rig keeps every turn of all {len(SEEDS)} seeds in its place up to {_most_noise(rig):g} A, which the mean makes
  {_most_noise(rig) / 11.2:.2g} A of; the linkage, which has no mean, up to {_most_noise(wiper):g} A.
* On the linkage it is noise of middle size that does the harm: the limit is then so low that the turn waits for the
  end of the revolution. With 2 A a sample falls below it as soon as the chart looks, half a period after the start.
* The average of chapter 4 buys a factor of {_most_noise(rig) / _next(_most_noise(wiper)):.0f} to
  {_next(_most_noise(rig)) / _most_noise(wiper):.0f} in noise. It costs a delay of 62 ms, which moves the turn by
  {0.062 * rate:.2f} of a revolution.
"""


def _healthy_cells(s: Sweep) -> str:
    return f"{np.median(s.healthy.turns):.3f} | {' | '.join(s.healthy.counts)}"


def _noise_cells(s: Sweep, sigma: float) -> str:
    places = [x for run in s.noisy[sigma] for x in run.turns]
    return f"{min(places):.3f} to {max(places):.3f} | {_missed(s, sigma)} of {_turn_total(s, sigma)}"


def _missed(s: Sweep, sigma: float) -> int:
    usual = float(np.median(s.healthy.turns))
    places = [r.turn_position for run in s.noisy[sigma] for r in run.revolutions]
    return sum(place is None or abs(place - usual) > RULES.position for place in places)


def _turn_total(s: Sweep, sigma: float) -> int:
    return sum(len(run.revolutions) for run in s.noisy[sigma])


def _most_noise(s: Sweep) -> float:
    """Return the largest noise tried [A] up to which no turn is missed or out of place."""
    bad = [sigma for sigma in SIGMAS if _missed(s, sigma)]
    return max(sigma for sigma in SIGMAS if sigma < min(bad, default=np.inf))


def _next(sigma: float) -> float:
    return SIGMAS[SIGMAS.index(sigma) + 1]


def _jump(run: Run) -> float:
    """Return the largest change of the learned period, as a share of the one before; the assumed one is left out."""
    periods = run.result.columns["controller.period"]
    learned = periods[np.flatnonzero(np.diff(periods)) + 1]
    return float(np.max(np.abs(np.diff(learned)) / learned[:-1]))


def _slope(s: Sweep) -> float:
    """Return how far the turn moves for the delay, from 60 ms to 400 ms [revolutions per second]."""
    chosen = [ms for ms in DELAYS if 60 <= ms <= 400]
    places = [float(np.median(s.late[ms].turns)) for ms in chosen]
    return float(np.polyfit(1e-3 * np.array(chosen), places, 1)[0])


def _speed(s: Sweep) -> float:
    closings = [at for at, _ in s.healthy.leads]
    return 1.0 / float(np.mean(np.diff(closings)))


def _parks_text(s: Sweep) -> str:
    found = sorted({run.score.counts_without_first.park_deceleration for ms, run in s.late.items() if ms <= 400})
    total = s.healthy.score.counts_without_first.park_total
    most = f"{found[0]}" if len(found) == 1 else f"{found[0]} to {found[-1]}"
    return f"{most} of {total}"


def draw(runs: dict[str, Run], sweeps: dict[str, Sweep]) -> None:
    """Write the three pictures."""
    import matplotlib as mpl

    mpl.use("Agg")
    PICTURES.mkdir(parents=True, exist_ok=True)
    _draw_contact(runs)
    _draw_sweep(
        "delay",
        sweeps,
        "delay of the current [ms]",
        {n: {ms: s.late[ms].turns for ms in DELAYS} for n, s in sweeps.items()},
    )
    _draw_sweep(
        "noise",
        sweeps,
        f"standard deviation of the noise [A], {len(SEEDS)} seeds",
        {n: {x: [p for run in s.noisy[x] for p in run.turns] for x in SIGMAS} for n, s in sweeps.items()},
    )


def _draw_contact(runs: dict[str, Run]) -> None:
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(8.0, 3.6), layout="constrained")
    axes.axvspan(*STUCK, color="0.5", alpha=0.15, linewidth=0)
    axes.text(STUCK[0] + 0.1, 470, "contact stuck", fontsize=9, color="0.3", va="top")
    styles = (("healthy", BLACK, "o", "-"), ("stuck open", BLUE, "s", "--"), ("stuck closed", RED, "^", ":"))
    for run, (label, colour, marker, line) in zip(_contacts(runs), styles, strict=True):
        times, leads = np.array([pair for pair in run.leads if pair[0] < 21.0 and pair[1] < NO_STOP]).T
        axes.plot(times, 1e3 * leads, marker=marker, color=colour, linestyle=line, markersize=5, label=label)
    axes.axhline(100, color=GREEN, linewidth=0.9, linestyle="-.", label="counted as predicted up to here")
    axes.set_xlabel("closing of the real contact [s]")
    axes.set_ylabel("lead of the planned stop [ms]")
    axes.set_ylim(-70, 1250)
    axes.grid(alpha=0.25)
    axes.spines[["top", "right"]].set_visible(False)
    figure.legend(fontsize=9, frameon=False, loc="outside upper center", ncols=4)
    figure.savefig(PICTURES / "contact.png", dpi=100)


def _draw_sweep(name: str, sweeps: dict[str, Sweep], label: str, found: dict[str, dict[float, list[float]]]) -> None:
    import matplotlib.pyplot as plt

    figure, grid = plt.subplots(1, 2, figsize=(9.0, 3.6), sharey=True, layout="constrained")
    for axes, (plant, points) in zip(grid, found.items(), strict=True):
        title, colour, marker = PLANTS[plant]
        usual = float(np.median(sweeps[plant].healthy.turns))
        axes.axhspan(usual - RULES.position, usual + RULES.position, color=colour, alpha=0.12, linewidth=0)
        axes.axhline(usual, color=BLACK, linewidth=0.9, linestyle="--")
        xs: NDArray[np.float64] = np.array([x for x, places in points.items() for _ in places], dtype=float)
        ys = np.array([place for places in points.values() for place in places])
        axes.plot(xs, ys, linestyle="none", marker=marker, markersize=3.5, color=colour, alpha=0.7)
        axes.set_title(title, fontsize=10, loc="left")
        axes.set_xlabel(label)
        axes.set_xscale("log" if name == "noise" else "linear")
        axes.set_ylim(-0.02, 1.05)
        axes.grid(alpha=0.25)
        axes.spines[["top", "right"]].set_visible(False)
    grid[0].set_ylabel("place of each turn\n[share of the revolution]")
    grid[0].text(
        0.98, 0.03, "dashed: healthy median; band: in place", transform=grid[0].transAxes, fontsize=8, ha="right"
    )
    figure.savefig(PICTURES / f"{name}.png", dpi=100)


def filled(text: str) -> str:
    """Return a page with its paragraphs and items in lines of 120 characters."""
    blocks = re.split(r"\n(?=\n|\* )", text)
    return "\n".join(_filled(block) for block in blocks)


def _filled(block: str) -> str:
    plain = block.lstrip("\n")
    if plain.startswith(("|", "#", "!", "```")) or not plain:
        return block
    indent = "  " if plain.startswith("* ") else ""
    lines = fill(" ".join(plain.split()), 120, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
    return block[: len(block) - len(plain)] + lines + ("\n" if plain.endswith("\n") else "")


def main() -> None:
    """Run all and write the page and the pictures."""
    runs, sweeps = shipped(), {name: sweep(name) for name in (RIG, WIPER)}
    (ROOT / "docs" / "faults.md").write_text(filled(page(runs, sweeps)), encoding="utf-8")
    draw(runs, sweeps)


if __name__ == "__main__":
    main()

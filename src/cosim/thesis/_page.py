"""The pages "the thesis, reproduced" and "claims of the source, tested" as Markdown, from the runs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from cosim.thesis._agreement import counts_of, sentences
from cosim.thesis._claims import Finding, Verdict
from cosim.thesis._evidence import Evidence
from cosim.thesis._measured import Measured
from cosim.thesis._numbers import NUMBERS
from cosim.thesis._parameters import Parameter
from cosim.thesis._readings import READINGS, STRICT
from cosim.thesis._table import PUBLISHED

COMMAND = "Made by `cosim thesis`: the numbers of the simulation are those of its runs, none is typed."


def thesis_page(
    evidence: Evidence, findings: Sequence[Finding], parameters: Sequence[Parameter], measured: Measured | None
) -> str:
    """Return the page that puts the output beside the source, figure by figure."""
    blocks = [
        "# The thesis, reproduced",
        "P. Fjellander, *Robust and Adaptive Motion Control for Windscreen Wiping on Commercial Vehicles*, KTH 2018, "
        f"TRITA-ITM-EX 2018:162, beside simulations of its models. {COMMAND} The figures have the source's numbers, "
        "axes and units. What the source claims is tested in [claims](claims.md).",
        "## The linkage",
        *_linkage(evidence, measured),
        "## The profile and the bridge",
        *_profile(evidence),
        "## The rig under the profile",
        *_rig(evidence),
        "## Table 4.1",
        *_table(evidence),
        "## The claims, in short",
        *_short(findings),
        "## Parameters",
        *_parameters(parameters),
    ]
    return "\n\n".join(blocks) + "\n"


def claims_page(findings: Sequence[Finding]) -> str:
    """Return the page with a verdict, numbers and a figure for every claim."""
    blocks = [
        "# Claims of the source, tested",
        f"{COMMAND} A verdict follows from its rule and the numbers; the rules are choices, and stand beside them. "
        "The other pictures are in [the thesis, reproduced](thesis.md).",
    ]
    shown: set[str] = set()
    for number, finding in enumerate(findings, 1):
        name = finding.picture
        blocks += [
            f"## {number}. {finding.claim[0].upper()}{finding.claim[1:]}",
            f"Source: {finding.place}. **Verdict: {finding.verdict.value}.**",
            f"Rule: {finding.rule}.",
            f"Numbers: {finding.numbers}.",
            f"[The picture is shown above.]({name})" if name in shown else _picture(name, name.removesuffix(".png")),
        ]
        shown.add(name)
    return "\n\n".join(blocks) + "\n"


def _picture(name: str, text: str) -> str:
    return f"![{text}]({name})"


def _markdown(head: Sequence[str], rows: Iterator[Sequence[object]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell).replace("|", "\\|") for cell in line) + " |" for line in lines)


def _linkage(evidence: Evidence, measured: Measured | None) -> Iterator[str]:
    naive, simple = (evidence.linkage[name] for name in ("naive", "simple"))
    position, speed, torque = (naive.columns[f"plant.{name}_ps"] for name in ("phi", "w", "tau"))
    moving = np.abs(speed) > 0.1 * np.abs(speed).max()
    yield _picture("wiper_system.png", "Linkage and wipers")
    yield (
        "Analytic plot of B.2.4: the linkage at one crank angle, both wipers at all of them. The lengths are those of "
        "the scripts, with their correction `corr3D`, without which the passenger side would not be a crank-rocker."
    )
    yield _picture("figure_3_5.png", "Figure 3.5")
    yield (
        f"Figure 3.5, naive load: the passenger side's rocker swings by {np.rad2deg(np.ptp(position)):.1f} deg, at up "
        f"to {np.abs(speed).max():.2f} rad/s. The torque is at most {np.abs(torque[moving]).max():.2f} N.m while it "
        f"moves, and {np.abs(torque[~moving]).max():.2f} N.m where it turns (below a tenth of its greatest speed). The "
        "source calls the peaks there mysterious; in the model they come from the block's friction, which sticks at "
        "standstill. Its numbers and the shape of the naive load are assumed."
    )
    yield _picture("figure_3_6.png", "Figure 3.6")
    peaks = [float(run.columns["plant.tau_crank"].max()) for run in (naive, simple)]
    yield (
        f"Figure 3.6: the crank torque peaks at {peaks[0]:.1f} N.m with the naive load and at {peaks[1]:.1f} N.m with "
        "the simple one of equation 3.1. "
        + (
            "The measured curve is the supplier's and not in the source; `cosim thesis --measured FILE` draws it."
            if measured is None
            else f"{measured.label}: mean {measured.torque.mean():.1f} N.m, greatest {measured.torque.max():.1f} N.m, "
            "a moving average over 0.11 s as in B.1.5."
        )
    )


def _profile(evidence: Evidence) -> Iterator[str]:
    pwm = evidence.pwm
    averaged = pwm.mean_current("averaged")
    yield _picture("figure_3_12.png", "Figure 3.12")
    yield (
        "Figure 3.12: the corners are those of B.1.8, to one tick of the chart. The source colours areas and calls the "
        "ratio V; here the line is coloured. Soft_stop takes Ts, as drawn there; everywhere else it takes Ts/2, as the "
        "chart says."
    )
    yield _picture("figure_4_8.png", "Figure 4.8")
    half = pwm.machine.half_ripple(pwm.duty, 1e-3)
    off = [100.0 * (pwm.mean_current(name) / averaged - 1.0) for name in ("100khz", "1khz", "10hz")]
    yield (
        f"Figure 4.8: the voltage falls from 1 to {pwm.duty:g} of the supply at 2 s (sizes and times are assumed; the "
        "inrush current is cut off as in the source's axes). Mean current over 4.5 s against the averaged bridge: "
        f"{off[0]:.2f} % more at 100 kHz, {off[1]:.1f} % at 1 kHz, {off[2]:.0f} % at 10 Hz. The ripple at 1 kHz is "
        f"within {100 * pwm.ripple_error():.1f} % of the closed form in every period."
    )
    yield _picture("figure_4_8_means.png", "Where the means part")
    yield (
        f"The means agree while the averaged bridge carries more than half the ripple, V d (1-d) T/(2 L) = {half:.2f} "
        f"A at 1 kHz: in {100 * float(pwm.flowing('1khz', 1e-3).mean()):.0f} % of its periods. Below, the current "
        "stops in each period and its mean follows the closed form."
    )


def _rig(evidence: Evidence) -> Iterator[str]:
    yield (
        "The current is the moving average over 0.125 s, as in the source, every other run braked and pushed in turn. "
        "Turns are dips to the least duty ratio of 35 %, revolutions end in dips to 70 %; grey lines are park signals."
    )
    rows = []
    for run in evidence.rig:
        name = f"figure_{NUMBERS[run.sample_time, run.load]}"
        park, time = run.result.columns["plant.park"], run.result.time
        current = run.result.columns["controller.i_filtered"][time > 1.0]
        rows.append((
            name.removeprefix("figure_").replace("_", "."), f"{1e3 * run.sample_time:.0f} ms", run.load,
            int(np.count_nonzero(np.diff(park) > 0)), f"{abs(current.min()):.2f} to {current.max():.2f} A",
        ))  # fmt: skip
    yield _markdown(
        ("figure", "sampling time", "load", "park signals in 25 s", "filtered current after 1 s"), iter(rows)
    )
    for run in evidence.rig:
        name = f"figure_{NUMBERS[run.sample_time, run.load]}"
        text = name.replace("_", " ", 1).replace("_", ".").capitalize()
        yield _picture(f"{name}.png", f"{text}, {1e3 * run.sample_time:.0f} ms, {run.load} load")


def _table(evidence: Evidence) -> Iterator[str]:
    reading = evidence.reading
    readings = dict.fromkeys((*READINGS, reading))
    yield f"{len(readings)} readings of the criteria; table_4_1_readings.csv has the counts of all, with both charts:"
    yield "\n".join(f"* `{each.name}`: {each.says}." for each in readings)
    yield (
        "`dip` stands for what the source did: it counted from plots of the voltage, and it rejects what happens after "
        "the signal. `cosim thesis --set early=50ms`, with the names of `cosim score`, puts another beside `strict`. A "
        "pair of counts is that of all revolutions and that without the first."
    )
    strict, other = counts_of(evidence.rig, STRICT), counts_of(evidence.rig, reading)
    full = counts_of(evidence.rig_full_stop, reading)
    without = {(run.sample_time, run.load): run.score.counts_without_first for run in evidence.rig}
    later = evidence.without_first(reading)
    yield _markdown(
        (
            "sampling", "load", "park, published", "strict", reading.name, f"{reading.name}, Soft_stop Ts",
            "turn, published", "turn",
        ),
        (
            (
                f"{1e3 * key[0]:.0f} ms", key[1], PUBLISHED[key][0],
                f"{strict[key].park_deceleration}/{strict[key].park_total}",
                f"{other[key].park_deceleration}/{other[key].park_total}, "
                f"{later[key].park_deceleration}/{later[key].park_total}",
                f"{full[key].park_deceleration}/{full[key].park_total}",
                PUBLISHED[key][1],
                f"{strict[key].turn}/{strict[key].turn_total}, {without[key].turn}/{without[key].turn_total}",
            )
            for key in PUBLISHED
        ),
    )  # fmt: skip
    yield "\n".join(f"* {sentence}" for sentence in sentences(evidence))
    yield (
        "How far these counts move with what the source leaves open, such as the rate of the chart, the noise or the "
        "length of Soft_stop, `cosim thesis --sensitivity` finds out by a designed experiment: sensitivity.md."
    )


def _short(findings: Sequence[Finding]) -> Iterator[str]:
    by_verdict = {verdict: sum(f.verdict is verdict for f in findings) for verdict in Verdict}
    yield "; ".join(f"{verdict.value}: {count}" for verdict, count in by_verdict.items()) + "."
    yield _markdown(("place", "claim", "verdict"), ((f.place, f.claim, f.verdict.value) for f in findings))


def _parameters(parameters: Sequence[Parameter]) -> Iterator[str]:
    stated = sum(p.stated for p in parameters)
    yield (
        f"All {len(parameters)} that a user can set, {stated} stated in the source ([S], with the place) and "
        f"{len(parameters) - stated} assumed ([A], with the reason); parameters.csv has them with their descriptions."
    )
    yield _markdown(
        ("name", "value", "unit", "in", "rig's runs", "provenance"),
        ((f"`{p.name}`", p.value, p.unit, ", ".join(p.models), p.rig_runs, p.provenance) for p in parameters),
    )

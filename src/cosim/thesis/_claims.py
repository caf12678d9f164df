"""What the source claims, each with a verdict that a rule derives from numbers of the runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from cosim.assessment import score
from cosim.thesis._evidence import Evidence
from cosim.thesis._experiments import late_decelerations


class Verdict(Enum):
    """What the numbers say of a claim."""

    HOLDS = "holds"
    PARTLY = "holds in part"
    FAILS = "does not hold"
    UNDECIDED = "the runs do not tell"


@dataclass(frozen=True)
class Finding:
    """A claim, where it stands, the rule by which it is judged, the numbers, and the picture that shows them."""

    place: str
    claim: str
    rule: str
    numbers: str
    verdict: Verdict
    picture: str


NEGLIGIBLE = 10.0
"""Damping over load from which "magnitudes greater" holds: one order of magnitude."""
GONE = 0.05
"""A disturbance is gone when it changes the speed by less than this share of what it did in its own revolution."""
ROUGHLY = 0.2
"""Relative difference that "roughly" allows."""
SAME_MEAN = 5e-3
"""Relative difference up to which a switched bridge has the mean current of the averaged one."""
SAME_TURN = 0.02
"""Two turns at places closer than this share of a revolution are at the same place."""


def judge(evidence: Evidence) -> list[Finding]:
    """Return a finding for each claim, in the order of the source."""
    rules: Sequence[Callable[[Evidence], Finding]] = (
        start_shock, least_pwm_frequency, deviation_from_rms, negligible_load, sufficient_pwm_frequency,
        first_revolution, late_at_50_ms, lower_derivative, filtering, todays_hardware, best_sampling_time,
        gone_after_a_revolution, power,
    )  # fmt: skip
    return [rule(evidence) for rule in rules]


def start_shock(evidence: Evidence) -> Finding:
    """Figure 1.1."""
    values = []
    for pair in evidence.pairs.values():
        started, settled = pair.measures(whole=True)[1], pair.measures(whole=False)[1]
        values.append(started["start_pin_acceleration"] / settled["pin_acceleration_peak"])
    soft = [pair.comparison(whole=True).ratios["start_pin_acceleration"] for pair in evidence.pairs.values()]
    started, settled = (evidence.pairs["linkage"].measures(whole=whole)[1] for whole in (True, False))
    return Finding(
        "figure 1.1",
        "the motor starts with a shock impulse of acceleration",
        "at constant voltage the greatest acceleration of the start is at least twice that afterwards, on both plants",
        f"linkage: crank pin {started['start_pin_acceleration']:.2f} m/s2 at the start, "
        f"{settled['pin_acceleration_peak']:.3f} m/s2 later, {values[0]:.0f} times less; rig {values[1]:.0f} times. "
        f"The soft start lowers it to {soft[0]:.2f} (linkage) and {soft[1]:.2f} (rig) of that at constant voltage",
        _all([value >= 2.0 for value in values]),
        "figure_1_1.png",
    )


def least_pwm_frequency(evidence: Evidence) -> Finding:
    """Equation 3.4."""
    flows = float(evidence.pwm.flowing("1khz", 1e-3).mean())
    least = 1.0 / evidence.pwm.machine.tau
    return Finding(
        "3.2.2, eq. 3.4",
        "a PWM frequency of at least 510 Hz, 1/tau_e, ensures smoothness in theory",
        f"at 1 kHz, well above 1/tau_e = {least:.0f} Hz, the current flows without stopping, as at the averaged bridge",
        f"at 1 kHz and a duty ratio of {evidence.pwm.duty:g} it flows on in {100 * flows:.0f} % of the periods; in the "
        "others it stops, and the motor turns faster than the duty ratio says",
        Verdict.HOLDS if flows == 1.0 else Verdict.PARTLY if flows > 0.9 else Verdict.FAILS,
        "figure_4_8_means.png",
    )


def deviation_from_rms(evidence: Evidence) -> Finding:
    """Section 3.5."""
    ratios = [pair.comparison(whole=False).ratios["current_deviation"] for pair in evidence.pairs.values()]
    return Finding(
        "3.5",
        "the deviation of the current from its RMS should be kept least, to which the profile is a means",
        "at the same wipe rate the profile's deviation is below that of constant voltage, on both plants",
        f"profile over constant voltage: linkage {ratios[0]:.2f}, rig {ratios[1]:.2f}",
        _all([ratio < 1.0 for ratio in ratios]),
        "claim_vibration.png",
    )


def negligible_load(evidence: Evidence) -> Finding:
    """Sections 3.6 and 5."""
    with_load, without = evidence.budgets["with"], evidence.budgets["without"]
    ratio = with_load.damping_torque / with_load.load_torque
    return Finding(
        "3.6, 5",
        "the external load is negligible beside the internal damping, which is magnitudes greater",
        f"damping takes at least {NEGLIGIBLE:g} times the mean crank torque that the load takes",
        f"damping {with_load.damping_torque:.2f} N.m, load {with_load.load_torque:.2f} N.m: {ratio:.1f} times. Without "
        f"the load a revolution is {100 * (1 - without.revolution / with_load.revolution):.1f} % shorter, the RMS of "
        f"the current {100 * (1 - without.current / with_load.current):.0f} % lower",
        Verdict.HOLDS if ratio >= NEGLIGIBLE else Verdict.FAILS,
        "claim_load.png",
    )


def sufficient_pwm_frequency(evidence: Evidence) -> Finding:
    """Section 4.4.1."""
    pwm = evidence.pwm
    averaged = pwm.mean_current("averaged")
    off = {name: pwm.mean_current(name) / averaged - 1.0 for name in ("100khz", "1khz", "10hz")}
    smooth = abs(off["100khz"]) < SAME_MEAN
    deviate = min(abs(off["1khz"]), abs(off["10hz"])) > SAME_MEAN
    return Finding(
        "4.4.1",
        "100 kHz suffices to actuate the motor smoothly; 1 kHz and 10 Hz deviate greatly",
        f"over figure 4.8 the mean current is within {100 * SAME_MEAN:g} % of the averaged bridge's at 100 kHz, and "
        "not at the other two",
        f"100 kHz {100 * off['100khz']:.2f} %, 1 kHz {100 * off['1khz']:.1f} %, 10 Hz {100 * off['10hz']:.0f} % more; "
        f"ripple at most {2e3 * pwm.machine.half_ripple(pwm.duty, 1e-5):.0f} mA at 100 kHz, "
        f"{2 * pwm.machine.half_ripple(pwm.duty, 1e-3):.2f} A at 1 kHz",
        _all([smooth, deviate]),
        "figure_4_8.png",
    )


def first_revolution(evidence: Evidence) -> Finding:
    """Section 4.5."""
    firsts = [score(run.result, evidence.reading.rules).revolutions[0] for run in evidence.rig]
    preset = score(evidence.preset, evidence.reading.rules).revolutions[0]
    parks, turns = sum(r.park_deceleration for r in firsts), sum(r.turn for r in firsts)
    return Finding(
        "4.5",
        "the first revolution always counts as a fail, by the algorithm's design",
        "in all ten runs the first revolution fails, the park as well as the turn prediction",
        f"parks predicted in {parks} of {len(firsts)} first revolutions, turns in {turns}; with half a revolution of "
        f"1.045 s preset the park {'is' if preset.park_deceleration else 'is not'} predicted and the turn "
        f"{'is' if preset.turn else 'is not'}: it is the period not yet learned, not the revolution's number",
        _all([parks == 0, turns == 0]),
        "figure_4_15.png",
    )


def late_at_50_ms(evidence: Evidence) -> Finding:
    """Sections 4.5 and 5."""
    found = [late_decelerations(run.result) for run in evidence.rig if run.sample_time == 0.05]
    late, scored = (sum(column) for column in zip(*found, strict=True))
    whole = next(unit for unit in evidence.slow if unit.period == 0.05)
    return Finding(
        "4.5, 5",
        "at 50 ms the deceleration happens after the park signal and not on it",
        "at 50 ms it comes after the signal only in more than half of the revolutions",
        f"in {late} of {scored} revolutions if the chart runs every millisecond, in {whole.late} of {whole.scored} if "
        "everything runs every 50 ms",
        _all([late > scored / 2, whole.late > whole.scored / 2]),
        "figure_4_17.png",
    )


def lower_derivative(evidence: Evidence) -> Finding:
    """Section 4.5."""
    start = [pair.comparison(whole=True).ratios["start_current_rate"] for pair in evidence.pairs.values()]
    after = [pair.comparison(whole=False).ratios["current_rate_peak"] for pair in evidence.pairs.values()]
    torque = [pair.comparison(whole=False).ratios["torque_rate_peak"] for pair in evidence.pairs.values()]
    return Finding(
        "4.5",
        "the profile improves comfort, because the derivative of the current is reduced",
        "at the same wipe rate the greatest rate of the current is below that of constant voltage, at the start and "
        "after it, on both plants",
        f"profile over constant voltage, linkage and rig: current at the start {start[0]:.2f} and {start[1]:.2f}, "
        f"afterwards {after[0]:.1f} and {after[1]:.1f}; crank torque afterwards {torque[0]:.1f} and {torque[1]:.1f}",
        _all([ratio < 1.0 for ratio in (*start, *after)]),
        "claim_vibration.png",
    )


def filtering(evidence: Evidence) -> Finding:
    """Section 5."""
    turns = {(turn.sample_time, turn.n_window): turn.share for turn in evidence.turns}
    fast, slow = turns[0.001, 50], turns[0.02, 50]
    short_window, long_window = turns[0.02, 3], turns[0.01, 100]
    differ = abs(fast - slow) > SAME_TURN
    by_window = abs(short_window - fast) <= SAME_TURN and abs(long_window - slow) <= SAME_TURN
    return Finding(
        "5",
        "slow sampling is a low-pass filter that affects the system in a desirable way",
        "turns move with the sampling time, and not as much with the length of the minimum's window alone "
        f"(by more than {SAME_TURN:g} of a revolution)",
        f"50 samples: turns after {fast:.2f} of the revolution at 1 ms, {slow:.2f} at 20 ms; at 20 ms with 3 samples "
        f"{short_window:.2f}, at 10 ms with 100 samples {long_window:.2f}. "
        + (
            "What sampling does is to stretch the window of the least current, from 50 ms to 2.5 s"
            if by_window
            else "The window alone does not explain it"
        ),
        Verdict.UNDECIDED if not differ else Verdict.FAILS if by_window else Verdict.HOLDS,
        "claim_sampling.png",
    )


def todays_hardware(evidence: Evidence) -> Finding:
    """Section 5."""
    texts = [f"{1e3 * unit.period:.0f} ms: {unit.seen} of {unit.contacts}" for unit in evidence.slow]
    slowest = max(evidence.slow, key=lambda unit: unit.period)
    return Finding(
        "5",
        "the controller can be implemented on today's hardware, though with a sampling time of 50 ms only",
        "a unit that does everything every 50 ms sees every park contact, which lasts about 12 ms",
        f"park contacts seen if the park input is sampled, too: {', '.join(texts)}. What else today's hardware can do "
        "is in none of the models",
        _all([slowest.seen == slowest.contacts]),
        "claim_sampling.png",
    )


def best_sampling_time(evidence: Evidence) -> Finding:
    """Section 6."""
    shares = evidence.shares
    ordered = sorted(shares.values(), reverse=True)
    best = max(shares, key=lambda time: shares[time])
    clear = ordered[0] - ordered[1] >= 1.0 / _events(evidence)
    texts = [f"{1e3 * time:.0f} ms {100 * share:.0f} %" for time, share in shares.items()]
    return Finding(
        "6",
        "20 ms is the best trade-off of performance and robustness",
        "parks and turns predicted, both loads together, are most at 20 ms, by more than one prediction of those of "
        "the next",
        f"{', '.join(texts)}; one prediction is {100 / _events(evidence):.1f} %. With what "
        "the source leaves open varied: sensitivity.md",
        Verdict.UNDECIDED if not clear else Verdict.HOLDS if best == 0.02 else Verdict.FAILS,
        "claim_sampling.png",
    )


def gone_after_a_revolution(evidence: Evidence) -> Finding:
    """Section 6."""
    gone = {case.name: bool(case.difference[2:].max() <= GONE) for case in evidence.aftermaths}
    texts = [f"{case.name} {100 * case.difference[2:].max():.0f} %" for case in evidence.aftermaths]
    return Finding(
        "6",
        "the effect of a sudden disturbance is gone after about one motor revolution",
        f"from the second revolution after it on, a torque of 5 N.m for 0.3 s changes the speed by at most "
        f"{100 * GONE:g} % of what it did in its own revolution",
        "greatest change left: " + ", ".join(texts),
        _all(list(gone.values())),
        "claim_disturbance.png",
    )


def power(evidence: Evidence) -> Finding:
    """Section 6."""
    found = evidence.budgets["with"].electrical
    return Finding(
        "6",
        "the motor needs roughly 72 W",
        f"the mean electrical power of the linkage at full voltage is within {100 * ROUGHLY:g} % of 72 W",
        f"{found:.1f} W on the linkage",
        Verdict.HOLDS if abs(found / 72.0 - 1.0) <= ROUGHLY else Verdict.FAILS,
        "claim_load.png",
    )


def _events(evidence: Evidence) -> int:
    return int(np.median([2 * (c.park_total + c.turn_total) for c in evidence.counts.values()]))


def _all(met: Sequence[bool]) -> Verdict:
    return Verdict.HOLDS if all(met) else Verdict.PARTLY if any(met) else Verdict.FAILS

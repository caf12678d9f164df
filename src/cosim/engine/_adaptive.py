"""Macro steps as long as the tolerance allows: each is taken whole and in two halves, which are compared and kept.

The errors of all steps are to add up to the tolerance at most, relative to the largest value so far: those of a step of
length h in the continuous states to the part h / stop of it. Links that feed through to outputs have errors that do not
add up, and may have the whole tolerance, unless the states behind them are unknown. Half steps of a method of order p
have 1 / (2^p - 1) of the difference (Hairer, Norsett, Wanner: Solving Ordinary Differential Equations I, II.4); the
step size is controlled with the error of the last step, too (PI control: Gustafsson, ACM TOMS 17, 1991, p. 533).
"""

from __future__ import annotations

from array import array
from math import sqrt

from cosim.engine._agreement import agree
from cosim.engine._coupling import INNER, OUTER, Coupling

SHORTEST = 1e-7
"""Macro step [s] that is not made any shorter."""
_SAFETY, _LEAST, _MOST = 0.9, 0.2, 4.0
_NOISE = 0.1
"""Differences below this part of the tolerance that do not fall with the step size are those of the FMUs' solvers."""
_FALLS = 0.8


def advance_adaptively(coupling: Coupling, now: float, t: float, recording: bool) -> int:
    """Step all members from ``now`` to t [s]; return the number of steps that stay."""
    longest = (t - now) / coupling.method.parts
    if coupling.method.step is not None:
        longest = min(longest, coupling.method.step)
    steps = 0
    while now < t:
        now = _step(coupling, now, t, longest, recording)
        steps += 2
    return steps


def _step(coupling: Coupling, now: float, t: float, longest: float, recording: bool) -> float:
    """Take one step from ``now``, in two halves; return where it ends [s]."""
    fresh = coupling.known == 0
    coupling.save(OUTER)
    last, noisy = 0.0, 0
    while True:
        rest = t - now
        wanted = min(coupling.wanted, longest)
        h = rest if wanted >= rest else 0.5 * rest if wanted > 0.5 * rest else wanted
        end = t if h == rest else now + h
        middle = now + 0.5 * h
        _solve(coupling, now, h, recording=False)
        _note(coupling)
        coupling.restore(OUTER)
        _solve(coupling, now, 0.5 * h, recording=False)
        coupling.push(now, 0.5 * h)
        _solve(coupling, middle, end - middle, recording=recording and end == t)
        error, plain = _errors(coupling, max(h, coupling.usual) if fresh else h)
        noisy = noisy + 1 if last > 0.0 and error > _FALLS * last and plain < _NOISE else 0
        if error <= 1.0 or h <= SHORTEST or noisy == 2:
            break
        last = error
        coupling.wanted = max(SHORTEST, h * max(_LEAST, min(_SAFETY, _SAFETY / sqrt(error))))
        coupling.rejected += 1
        coupling.restore(OUTER)
    coupling.forced += not error <= 1.0
    coupling.push(middle, end - middle)
    coupling.macro_steps += 2
    if not fresh:
        coupling.usual = h
    factor = _SAFETY * max(error, 1e-4) ** -0.35 * coupling.error**0.2
    coupling.error = max(error, 1e-4)
    if h == wanted or factor < 1.0:
        coupling.wanted = max(SHORTEST, h * max(_LEAST, min(_MOST, factor)))
    return end


def _solve(coupling: Coupling, t: float, h: float, recording: bool) -> None:
    """Take one step; without polynomials to begin with, twice, the second time with what the first has given."""
    coupling.predict(t, h)
    if coupling.method.loops:
        agree(coupling, t, h, recording)
        return
    if coupling.known == 0:
        coupling.save(INNER)
        coupling.take(t, h, recording=False)
        coupling.correct_again(recording=False)
        ends = array("d", [link.of(coupling.values) for link in coupling.links])
        coupling.restore(INNER)
        coupling.repeated += 1
        memoryview(coupling.end)[:] = memoryview(ends)
    coupling.take(t, h, recording)
    coupling.correct_again(recording)


def _note(coupling: Coupling) -> None:
    """Keep what a step taken whole has led to."""
    for i, link in enumerate(coupling.links):
        coupling.full[i] = link.of(coupling.values)
    for member in coupling.members:
        if member.observed is not None:
            member.observe()
            memoryview(member.observed.full)[:] = memoryview(member.observed.values)


def _errors(coupling: Coupling, h: float) -> tuple[float, float]:
    """Return the largest error of a step in two halves over what is allowed, and over the whole tolerance."""
    whole = coupling.divisor * coupling.tolerance / coupling.method.parts**coupling.method.accuracy
    part = h / coupling.stop
    worst = plain = 0.0
    for i, link in enumerate(coupling.links):
        value = link.of(coupling.values)
        error = abs(value - coupling.full[i]) / (whole * max(coupling.scale[i], abs(value)))
        plain = error if not error <= plain else plain
        if not link.observed:
            error = error / part
        worst = error if not error <= worst else worst
    for member in coupling.members:
        observed = member.observed
        if observed is not None:
            member.observe()
            for k, value in enumerate(observed.values):
                observed.scale[k] = max(observed.scale[k], abs(value))
                error = abs(value - observed.full[k]) / (whole * observed.scale[k])
                plain = error if not error <= plain else plain
                error = error / part
                worst = error if not error <= worst else worst
    return worst, plain

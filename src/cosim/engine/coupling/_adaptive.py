"""Macro steps as long as the tolerance allows: each is taken whole and in two halves, which are compared and kept.

The errors of all steps are to add up to the tolerance at most, relative to the largest value so far: those of a step of
length h in the continuous states to the part h / stop of it. Links that feed through to outputs have errors that do not
add up, and may have the whole tolerance, unless the states behind them are unknown. Half steps of a method of order p
have 1 / (2^p - 1) of the difference (Hairer, Norsett, Wanner: Solving Ordinary Differential Equations I, II.4); the
step size is controlled with the error of the last step, too (PI control: Gustafsson, ACM TOMS 17, 1991, p. 533).

A step that a component does not finish, or at whose end the components find no agreement, is tried again shorter: what
it was given may have been too far off. Only the shortest step may fail.
"""

from __future__ import annotations

from array import array
from math import inf, isfinite, isnan, sqrt

from cosim.engine.coupling._agreement import agree
from cosim.engine.coupling._coupling import INNER, OUTER, Coupling
from cosim.engine.fmu._instance import CallError

SHORTEST = 1e-7
"""Macro step [s] that is not made any shorter; of a run of less than a second, that part of its duration."""
RESOLUTION = 1e-14
"""As a part of the time reached: no step is shorter, since the time would not go on by just that."""
_SAFETY, _LEAST, _MOST = 0.9, 0.2, 4.0
_NOISE = 0.1
"""Differences below this part of the tolerance that do not fall with the step size are those of the FMUs' solvers."""
_FALLS = 0.8
_AGREES = 0.1
"""Part of a signal by which the whole step and its halves may differ to tell how large the signal becomes."""
_ERROR = 1e-4
"""Least error over what is allowed that the control of the step size heeds; its reciprocal is the largest."""


def advance_adaptively(coupling: Coupling, now: float, t: float, recording: bool) -> int:
    """Step all members from ``now`` to t [s]; return the number of steps that stay."""
    longest = (t - now) / coupling.method.parts
    if coupling.method.step is not None:
        longest = min(longest, coupling.method.step)
    shortest = max(SHORTEST * min(coupling.stop, 1.0), RESOLUTION * t)
    steps = 0
    while now < t:
        now = _step(coupling, now, t, (shortest, longest), recording)
        steps += 2
    return steps


def _step(coupling: Coupling, now: float, t: float, limits: tuple[float, float], recording: bool) -> float:
    """Take one step from ``now``, in two halves; return where it ends [s]."""
    shortest, longest = limits
    fresh = coupling.known == 0
    coupling.save(OUTER)
    last, noisy = 0.0, 0
    while True:
        rest = t - now
        wanted = min(max(coupling.wanted, shortest), longest)
        h = rest if wanted >= rest else 0.5 * rest if wanted > 0.5 * rest else wanted
        end = t if h == rest else now + h
        middle = now + 0.5 * h
        try:
            _take_in_halves(coupling, now, h, end, recording and end == t)
            error, plain = _errors(coupling, max(h, coupling.usual) if fresh else h)
        except CallError as failure:
            if h <= shortest or failure.instance.is_broken:
                raise
            error = plain = inf
        noisy = noisy + 1 if last > 0.0 and error > _FALLS * last and plain < _NOISE else 0
        if error <= 1.0 or h <= shortest or noisy == 2:
            break
        last = error
        coupling.wanted = h * max(_LEAST, min(_SAFETY, _SAFETY / sqrt(error)))
        coupling.rejected += 1
        coupling.restore(OUTER)
    if error == inf and (reason := lost(coupling)) is not None:
        raise reason
    coupling.forced += error > 1.0
    coupling.push(middle, end - middle)
    coupling.enlarge()
    coupling.macro_steps += 2
    if not fresh:
        coupling.usual = h
    error = min(max(error, _ERROR), 1.0 / _ERROR)
    factor = _SAFETY * error**-0.35 * coupling.error**0.2
    coupling.error = error
    if h == wanted or factor < 1.0:
        coupling.wanted = h * max(_LEAST, min(_MOST, factor))
    return end


def _take_in_halves(coupling: Coupling, now: float, h: float, end: float, recording: bool) -> None:
    """Take a step of length h [s] whole, note what that leads to, and take it in halves, to exactly ``end`` [s]."""
    middle = now + 0.5 * h
    _solve(coupling, now, h, recording=False)
    _note(coupling)
    coupling.restore(OUTER)
    _solve(coupling, now, 0.5 * h, recording=False)
    coupling.push(now, 0.5 * h)
    _solve(coupling, middle, end - middle, recording)


def lost(coupling: Coupling) -> CallError | None:
    """Return the error for the first linked input or state that is no finite number; None if there is none."""
    for member in coupling.members:
        instance = member.participant.instance
        numbers = {f"input {coupling.links[i].name}": coupling.links[i].of(coupling.values) for i in member.links}
        if member.observed is not None:
            names = (f"state {instance.name}.{name}" for name in instance.fmu.state_names)
            numbers |= zip(names, member.observed.values, strict=True)
        for name, number in numbers.items():
            if not isfinite(number):
                what = f"its {name} becomes {number}, however short the macro step"
                return CallError(instance, what, "check its parameters, and what its inputs are driven by at that time")
    return None


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
    """Return the largest error of a step in two halves over what is allowed, and over the whole tolerance.

    Magnitudes on which the whole step and its halves agree roughly are noted, even if the step is rejected: the signals
    will come to them. Others may be those of a step so long that it runs away.
    """
    whole = coupling.divisor * coupling.tolerance / coupling.method.parts**coupling.method.accuracy
    part = h / coupling.stop
    worst = plain = 0.0
    for i, link in enumerate(coupling.links):
        value = link.of(coupling.values)
        size, difference = abs(value), abs(value - coupling.full[i])
        if difference <= _AGREES * size:
            coupling.scale[i] = max(coupling.scale[i], size)
        error = difference / (whole * max(coupling.scale[i], size))
        error = inf if isnan(error) else error
        plain = max(plain, error)
        if not link.observed:
            error = error / part
        worst = max(worst, error)
    for member in coupling.members:
        observed = member.observed
        if observed is not None:
            member.observe()
            for k, value in enumerate(observed.values):
                size, difference = abs(value), abs(value - observed.full[k])
                if difference <= _AGREES * size:
                    observed.scale[k] = max(observed.scale[k], size)
                error = difference / (whole * max(observed.scale[k], size))
                error = inf if isnan(error) else error
                plain = max(plain, error)
                error = error / part
                worst = max(worst, error)
    return worst, plain

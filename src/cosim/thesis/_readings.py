"""Readings of the criteria of section 4.5: at their word, as plots show them, as the 50 ms lines count."""

from __future__ import annotations

from dataclasses import dataclass

from cosim.assessment import Rules

T_RAMP = 0.1
"""Duration of a ramp of the profile [s], table 3.5; Soft_start brings the voltage back to full in it."""


@dataclass(frozen=True)
class Reading:
    """How the criteria are read: a name for files, the rules of the scorer, and what they mean in words."""

    name: str
    rules: Rules
    says: str


STRICT = Reading(
    "strict",
    Rules(),
    "at its word: the profile is in turn_point_dec (literal) or in it or Soft_stop (deceleration) at the very instant "
    "of the park signal",
)
DIP = Reading(
    "dip",
    Rules(early=T_RAMP),
    "as a plot shows it: the park signal falls into the dip of the voltage, Soft_stop and the Soft_start that brings "
    "it back within 0.1 s; a deceleration that begins with the signal or after it is an answer and no prediction",
)
"""The chosen one. The plots from which the source counted show the voltage and no states, a dip is what can be seen in
them; and the source rejects decelerations that happen "after the park signal and not on it" (section 4.5)."""
ANSWER = Reading(
    "answer",
    Rules(early=T_RAMP, late=0.02, repeats="separate"),
    "any deceleration near the signal, also one that answers it, however often: what the published lines for 50 ms "
    "count, although the source disregards them",
)
READINGS = (STRICT, DIP, ANSWER)


def chosen(rules: Rules | None) -> Reading:
    """Return the reading that stands beside the strict one: that of a plot, or one with the rules that are given."""
    return DIP if rules is None else Reading("chosen", rules, "as it was asked for: " + _changes(rules))


def _changes(rules: Rules) -> str:
    return ", ".join(f"{name} = {value}" for name, value in vars(rules).items())

"""Columns that drive an input connector of a whole system structure, and through it inputs of its components."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from cosim.engine import Channel, Component, Variable
from cosim.errors import InputError
from cosim.scenario._model import Column
from cosim.scenario._names import End, dotted
from cosim.scenario._values import channel_values, check_range
from cosim.ssp import Input, Tap, same
from cosim.units import parse


def connector_channels(
    path: Path, column: Column, connector: Input, components: Sequence[Component], driven: Mapping[End, str]
) -> list[Channel]:
    """Return a channel for each input that a connector drives, in the FMUs' units.

    Raises `InputError` for a unit or a value that does not fit the connector or an input.
    """
    if not connector.taps:
        raise InputError(f"column '{column.name}': this connector drives nothing; remove the column")
    values = channel_values(path, column, connector.name, _as_variable(connector))
    variables = {(c.name, v.name): v for c in components for v in c.fmu.variables.values()}
    channels: list[Channel] = []
    for tap in connector.taps:
        if tap.target in driven:
            raise InputError(
                f"column '{column.name}': '{dotted(tap.target)}' is driven already {driven[tap.target]}; remove one"
            )
        reached = [_through(tap, value) for value in values]
        for value, line in zip(reached, column.lines, strict=True):
            try:
                check_range(value, dotted(tap.target), variables[tap.target])
            except InputError as error:
                raise InputError(str(error), file=path, line=line, column=column.position) from None
        channels.append(Channel(tap.target, list(column.times), reached, column.linear))
    return channels


def _through(tap: Tap, value: float) -> float:
    if tap.table:
        return dict(tap.table).get(value, value)
    return value if (tap.factor, tap.offset) == (1.0, 0.0) else tap.factor * value + tap.offset


def _as_variable(connector: Input) -> Variable:
    """Return the connector as an input variable; its unit only if its name means here what the SSP defines it as."""
    unit = None
    if connector.unit is not None:
        try:
            known = parse(connector.unit.text)
        except InputError:
            known = None
        if known is not None and same(known, connector.unit):
            unit = connector.unit.text
    return Variable(connector.name, connector.type, "input", "continuous", unit, None, None, 0, connector.literals)

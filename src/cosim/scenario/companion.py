"""The scenario that goes with an exported SSP: what the standard has no place for, such as the rows of channels."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence

from cosim.engine import Channel, System
from cosim.errors import InputError
from cosim.scenario._faults import fault_line
from cosim.scenario._model import Scenario
from cosim.units import parse


def companion(scenario: Scenario, system: System, connectors: Mapping[tuple[str, str], str], ssp: str) -> str:
    """Return a scenario file that runs the SSP of the path ``ssp`` as the scenario ran: the same numbers, to the bit.

    ``system`` is what the scenario has been assembled to, ``connectors`` are the SSP's by the variables behind them.
    The values are those of the channels and the faults, in the FMUs' units. Parameters are not in it, the SSP has them.
    """
    keys = {
        "title": scenario.title,
        "system": ssp,
        "stop": f"{scenario.stop!r} s",
        "output_interval": f"{scenario.output_interval!r} s",
        "tolerance": repr(scenario.tolerance),
        "algorithm": scenario.algorithm if scenario.algorithm != "auto" else "",
        "macro_step": f"{scenario.macro_step!r} s" if scenario.macro_step is not None else "",
        "extrapolation": "" if scenario.extrapolation is None else str(scenario.extrapolation),
        "linear": ", ".join(connectors[channel.target] for channel in system.channels if channel.linear),
    }
    lines = [f"# {key}: {value}\n" for key, value in keys.items() if value]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    variables = {(c.name, v.name): v for c in system.components for v in c.fmu.variables.values()}
    lines += [f"# fault: {fault_line(fault, variables[fault.target])}\n" for fault in system.faults]
    header = [_header(connectors[c.target], variables[c.target].unit) for c in system.channels]
    writer.writerow(["time [s]", *header])
    for time, cells in _rows(system.channels):
        writer.writerow([repr(time), *cells])
    return "".join(lines) + text.getvalue()


def _header(name: str, unit: str | None) -> str:
    """Return ``name [unit]``; without the unit if only the FMU's maker understands it, as numbers are taken then."""
    try:
        known = unit is not None and parse(unit)
    except InputError:
        known = False
    return f"{name} [{unit}]" if known else name


def _rows(channels: Sequence[Channel]) -> list[tuple[float, list[str]]]:
    """Return the rows of the table; a time has two where a channel has a step."""
    rows: dict[tuple[float, int], list[str]] = {}
    for column, channel in enumerate(channels):
        before = None
        for time, value in zip(channel.times, channel.values, strict=True):
            cells = rows.setdefault((time, int(time == before)), [""] * len(channels))
            cells[column] = repr(value)
            before = time
    return [(time, cells) for (time, _), cells in sorted(rows.items())]

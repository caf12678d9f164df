"""What a run tells of the exchange between its components: delays, coupling errors and energies."""

from __future__ import annotations

from collections.abc import Container, Mapping
from typing import Any

from cosim.cli._screen import Screen
from cosim.engine import EXACT

_SHOWN = 12
"""The table has so many connections, those that are off most; summary.json has all."""


def show_coupling(summary: Mapping[str, Any], screen: Screen) -> None:
    """Print the connections whose error is not none; one line if there is no such connection, nothing without any."""
    entries: list[dict[str, Any]] = summary["coupling"]
    if not screen.talks or not entries:
        return
    inexact = [entry for entry in entries if entry["note"] != EXACT]
    if not inexact:
        screen.say(f"coupling error: none, all {len(entries)} connections are sampled")
        return
    from rich.console import Console
    from rich.table import Table

    inexact.sort(key=lambda entry: -(entry["relative"] or 0.0))
    table = Table("connection", title="Coupling error, estimated", title_justify="left", box=None, pad_edge=False)
    for heading in ("delay", "error", "of range", "falls with"):
        table.add_column(heading, justify="right")
    for entry in inexact[:_SHOWN]:
        table.add_row(f"{entry['source']} -> {entry['target']}", *_cells(entry))
    Console().print(table, highlight=False)
    others = [note for note in dict.fromkeys(entry["note"] for entry in inexact) if note]
    sources = {entry["source"] for entry in inexact}
    others += dict.fromkeys(text for entry in inexact[:_SHOWN] if (text := _carried_on(entry, sources)))
    if len(inexact) > _SHOWN:
        others.append(f"{len(inexact) - _SHOWN} more connections are in summary.json")
    if len(inexact) < len(entries):
        others.append(f"{len(entries) - len(inexact)} more connections are sampled, without such an error")
    for text in others:
        screen.say(text)


def show_power(summary: Mapping[str, Any], screen: Screen) -> None:
    """Print a line for each power connection: what the coupling has added to the energy that goes over it."""
    for entry in summary["power"] if screen.talks else ():
        name = f"energy of {entry['effort']} * {entry['flow']}"
        if entry["error_J"] is None:
            screen.say(f"{name}: {entry['note']}")
            continue
        share = f", {100.0 * entry['relative']:.2g} % of it" if entry["relative"] is not None else ""
        note = f" ({entry['note']})" if entry["note"] else ""
        added = f"{entry['error_J']:.2g} J added by the coupling{share}{note}"
        screen.say(f"{name}: {entry['exchanged_J']:.3g} J exchanged, {added}")


def _cells(entry: Mapping[str, Any]) -> tuple[str, ...]:
    delay, error, relative, order = (entry[key] for key in ("delay_s", "error", "relative", "order"))
    unit = f" {entry['unit']}" if entry["unit"] not in (None, "1") else ""
    return (
        f"{delay:.3g} s" if delay is not None else "",
        f"{error:.2g}{unit}" if error is not None else "not known",
        f"{100.0 * relative:.2g} %" if relative is not None else "",
        f"h^{order}" if order is not None else "",
    )


def _carried_on(entry: Mapping[str, Any], sources: Container[str]) -> str:
    """Tell of a signal that is right itself, but not what its target makes of it, if that has no line of its own."""
    worst = entry["target_outputs"]
    if (
        not worst
        or worst["output"] in sources
        or not worst["relative"]
        or entry["relative"] is None
        or worst["relative"] <= 2.0 * entry["relative"]
    ):
        return ""
    return f"{worst['output']}, which is not handed on, is off by {100.0 * worst['relative']:.2g} % of its range"

"""The page that an FMU carries about itself: interface, parameters with their provenance, equations."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from html import escape

from cosim import __version__
from cosim.dae import Dae, explain
from cosim.fmu.layout import COUNTERS, Layout, Slot

_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; max-width: 68em; margin: 2em auto; padding: 0 1em; color: #1c2430 }
h1, h2 { color: #1f4e79; line-height: 1.2 }
table { border-collapse: collapse; width: 100% }
th, td { text-align: left; vertical-align: top; padding: .2em .7em .2em 0; border-bottom: 1px solid #dde5ee }
td.n { text-align: right; white-space: nowrap } code, pre { font: 13px/1.4 ui-monospace, monospace }
pre { white-space: pre-wrap; background: #f3f6fa; padding: .8em } .at { color: #6b7a8c }
"""
_PROVENANCE = re.compile(r"\s*(\[[^\]]{1,3}\]\s.*)$", re.DOTALL)
_PLACE = re.compile(r"\s\(([^()]+:\d+)\)$")


def document_model(dae: Dae, layout: Layout, tools: Mapping[str, str | None], fixed_step: float | None) -> bytes:
    """``documentation/index.html``, one file without scripts or references to others.

    Args:
        dae: the model.
        layout: its variables.
        tools: versions of what the FMU was made with, by name.
        fixed_step: the length of the solver's steps [s], ``None`` for error control.
    """
    slots = layout.slots
    name = escape(dae.name)
    ports = [s for s in slots if s.causality in ("input", "output")]
    free = [s for s in slots if s.causality == "parameter"]
    bound = [s for s in slots if s.causality == "calculatedParameter"]
    others = [s for s in slots if s.causality == "local" and s.name not in COUNTERS]
    parts = [
        f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>{name}</title>',
        f"<style>{_STYLE}</style></head>",
        f"<body><h1>{name}</h1><p>{escape(dae.description or '')}</p>",
        "<h2>Inputs and outputs</h2>",
        _table(("name", "", "start", "unit", "description"),
               ((_code(s.name), escape(s.causality), _number(s), _unit(s), _about(s)[0]) for s in ports)),
        "<h2>Parameters</h2><p>Where each value comes from stands beside it; [S]: stated in the source, [A]: assumed. "
        "Tunable ones may be set while a simulation runs.</p>",
        _table(("name", "value", "unit", "", "description", "provenance"),
               ((_code(s.name), _number(s), _unit(s), s.variability, *_about(s)) for s in free)),
        _details(f"{len(bound)} parameters that follow from these",
                 _table(("name", "unit", "description"), ((_code(s.name), _unit(s), _about(s)[0]) for s in bound))),
        _details(f"{len(others)} other variables",
                 _table(("name", "unit", "description"), ((_code(s.name), _unit(s), _about(s)[0]) for s in others))),
        "<h2>Equations</h2><p>After the elimination of aliases and the differentiation of constraints, with the place "
        "of each in the model's source.</p>",
        "<table>" + "".join(_equation(e) for e in dae.equations) + "</table>",
        _discrete(dae),
        "<h2>How they are solved</h2><pre>" + escape(explain(dae)) + "</pre>",
        "<h2>Provenance</h2>",
        _table(("", ""), [
            ("model", _code(dae.name)),
            ("made with", escape(f"wiper-cosim {__version__}; "
                                 + ", ".join(f"{tool} {found}" for tool, found in sorted(tools.items()) if found))),
            ("solver", "RODAS5P (Rosenbrock, order 5, index 1), "
                       + (f"steps of {fixed_step:g} s" if fixed_step else "error control, event location")),
            ("licence of the runtime", "MIT-0, see licenses/LICENSE.txt; the FMI headers keep their own"),
        ]),
        "</body></html>\n",
    ]  # fmt: skip
    return "\n".join(parts).encode()


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    numeric = {k for k, title in enumerate(head) if title in ("value", "start")}
    title = "<tr>" + "".join(f"<th>{text}</th>" for text in head) + "</tr>" if any(head) else ""
    body = ""
    for row in rows:
        cells = (f'<td class="n">{c}</td>' if k in numeric else f"<td>{c}</td>" for k, c in enumerate(row))
        body += f"<tr>{''.join(cells)}</tr>"
    return f"<table>{title}{body}</table>" if body else "<p>None.</p>"


def _details(summary: str, content: str) -> str:
    return f"<details><summary>{summary}</summary>{content}</details>"


def _equation(text: str) -> str:
    place = _PLACE.search(text)
    equation = text[: place.start()] if place else text
    return f'<tr><td>{_code(equation)}</td><td class="at">{escape(place[1]) if place else ""}</td></tr>'


def _discrete(dae: Dae) -> str:
    texts = dict.fromkeys(a.text for a in dae.assignments if not a.targets[0].startswith("$"))
    if not texts:
        return ""
    rows = "".join(f"<tr><td>{_code(text)}</td></tr>" for text in texts)
    return f"<h2>Discrete equations</h2><p>They hold at events.</p><table>{rows}</table>"


def _about(slot: Slot) -> tuple[str, str]:
    """Description and provenance."""
    text = slot.description or ""
    found = _PROVENANCE.search(text)
    return (escape(text[: found.start()]), escape(found[1])) if found else (escape(text), "")


def _number(slot: Slot) -> str:
    if slot.start is None:
        return ""
    if slot.type == "TYPE_BOOLEAN":
        return "true" if slot.start else "false"
    if slot.type == "TYPE_ENUMERATION" and slot.scalar is not None:
        return escape(slot.scalar.declaration.literals[int(slot.start) - 1])
    return f"{slot.start:.9g}"


def _unit(slot: Slot) -> str:
    return escape((slot.scalar.declaration.unit or "") if slot.scalar is not None else "")


def _code(text: str) -> str:
    return f"<code>{escape(text)}</code>"

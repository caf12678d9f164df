"""``cosim info``: an FMU at a glance."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from rich.console import Console
from rich.table import Table

from cosim.check import About, Description, describe
from cosim.cli._builtin import locate
from cosim.cli._screen import Screen
from cosim.errors import InputError

_WIDTH = 100
_SHOWN = {
    "input": "Inputs",
    "output": "Outputs",
    "structuralParameter": "Structural parameters",
    "parameter": "Parameters",
}
_KINDS = {
    **{kind: title.lower() for kind, title in _SHOWN.items()},
    "calculatedParameter": "calculated parameters",
    "local": "locals",
}
_INTERFACES = {
    "CoSimulation": "Co-Simulation",
    "ModelExchange": "Model Exchange",
    "ScheduledExecution": "Scheduled Execution",
}
_CAPABILITIES = {
    "canhandlevariablecommunicationstepsize": "variable steps",
    "cangetandsetfmustate": "get and set state",
    "canserializefmustate": "serialize state",
    "providesdirectionalderivative": "directional derivatives",
    "providesadjointderivative": "adjoint derivatives",
    "haseventmode": "event mode",
    "providesintermediateupdate": "intermediate update",
    "mightreturnearlyfromdostep": "might return early",
    "canreturnearlyafterintermediateupdate": "can return early",
    "caninterpolateinputs": "interpolates inputs",
    "canrunasynchronuously": "runs asynchronously",
    "needsexecutiontool": "needs its tool",
    "canbeinstantiatedonlyonceperproces": "one instance in a process only",
    "providesevaluatediscretestate": "evaluates discrete states",
    "providesperelementdependencie": "dependencies of elements",
}
_NUMBERS = {
    "maxOutputDerivativeOrder": "derivatives of outputs up to order {}",
    "fixedInternalStepSize": "fixed step of {} s inside",
    "recommendedIntermediateInputSmoothness": "smooth inputs up to order {}",
}


def show(name: str, screen: Screen) -> None:
    """Print an FMU's description; ``name`` is a path ending in .fmu or the name of a built-in one."""
    path = Path(name)
    if path.suffix.lower() != ".fmu" and not path.is_file():
        with screen.working(f"getting {name} ready"):
            path = locate(name)
    elif not path.is_file():
        raise InputError("there is no such FMU", file=path)
    found = describe(path)
    for text in found.amiss:
        screen.warn(f"{path}: {text}")
    screen.document(_document(found))
    if screen.talks:
        _print(found)


def _document(found: Description) -> dict[str, object]:
    """Return all there is for JSON, which knows no infinity."""
    return {
        "path": str(found.path),
        **found.facts,
        "size": found.size,
        "unpacked_size": found.unpacked_size,
        "platforms": found.binaries,
        "has_sources": found.has_sources,
        "interfaces": found.interfaces,
        "default_experiment": found.experiment,
        "states": found.n_states,
        "event_indicators": found.n_indicators,
        "variables": len(found.variables),
        "interface": [_plain(variable) for variable in _sorted(found.variables)],
        "warnings": list(found.amiss),
    }


def _sorted(variables: Sequence[About]) -> list[About]:
    """Inputs and outputs as the model has them; parameters, those of the model itself first, by name."""
    kinds = list(_SHOWN)
    shown = [variable for variable in variables if variable.causality in kinds]
    return sorted(shown, key=lambda v: (kinds.index(v.causality), *_rank(v)))


def _rank(variable: About) -> tuple[object, ...]:
    is_parameter = variable.causality in ("parameter", "structuralParameter")
    return ("." in variable.name, variable.name.lower()) if is_parameter else ()


def _plain(variable: About) -> dict[str, object]:
    start = variable.start
    values = [
        str(value) if isinstance(value, float) and not math.isfinite(value) else value
        for value in (start if isinstance(start, list) else [start])
    ]
    return asdict(variable) | {"start": values if isinstance(start, list) else values[0]}


def _print(found: Description) -> None:
    console = Console(highlight=False, markup=False)
    console.width = min(console.width, _WIDTH) if console.is_terminal else _WIDTH
    about = Table.grid(padding=(0, 2))
    about.add_column(no_wrap=True)
    about.add_column(overflow="fold")
    for key, value in _rows(found):
        if value:
            about.add_row(key, value)
    console.print(about)
    for causality, title in _SHOWN.items():
        variables = [variable for variable in _sorted(found.variables) if variable.causality == causality]
        if variables:
            console.print()
            console.print(f"{title} ({len(variables)})")
            console.print(_table(variables))


def _rows(found: Description) -> list[tuple[str, str]]:
    facts = {key: value or "" for key, value in found.facts.items()}
    counts = Counter(variable.causality for variable in found.variables)
    experiment = found.experiment
    begin, stop = experiment.get("startTime", 0.0), experiment.get("stopTime")
    parts = [f"{begin:g} s to {stop:g} s" if stop is not None else f"from {begin:g} s on"] if experiment else []
    parts += [f"tolerance {value:g}"] if (value := experiment.get("tolerance")) is not None else []
    parts += [f"step {value:g} s"] if (value := experiment.get("stepSize")) is not None else []
    platforms = [f"{name} ({_size(size)})" for name, size in found.binaries.items()]
    platforms += ["sources"] if found.has_sources else []
    made = ", ".join(part for part in (facts["generation_tool"], facts["generation_date"]) if part)
    return [
        ("model", facts["model"] + (f", version {facts['version']}" if facts["version"] else "")),
        ("", facts["description"]),
        ("FMI", facts["fmi_version"]),
        *((_INTERFACES[name], _capabilities(claims)) for name, claims in found.interfaces.items()),
        ("states", f"{found.n_states} continuous, {found.n_indicators} event indicators" if found.n_states else ""),
        ("platforms", ", ".join(platforms) or "none"),
        ("experiment", ", ".join(parts)),
        ("made by", made),
        ("author", facts["author"]),
        ("license", ", ".join(part for part in (facts["license"], facts["copyright"]) if part)),
        ("variables", ", ".join(f"{counts[kind]} {plural}" for kind, plural in _KINDS.items() if counts[kind])),
        ("file", f"{found.path} ({_size(found.size)}, unpacked {_size(found.unpacked_size)})"),
        ("sha256", facts["sha256"]),
    ]


def _capabilities(claims: dict[str, bool | int | float | str]) -> str:
    """Return what an interface can, in words."""
    lower = {name.lower().rstrip("s"): value for name, value in claims.items()}
    words = [word for name, word in _CAPABILITIES.items() if lower.get(name) is True]
    words += [text.format(claims[name]) for name, text in _NUMBERS.items() if claims.get(name)]
    return ", ".join(words) or "yes"


def _size(size: int) -> str:
    return f"{size / 1e6:.1f} MB" if size >= 1e6 else f"{math.ceil(size / 1000)} kB"


def _table(variables: Sequence[About]) -> Table:
    """Return the variables of one causality; a column that all of them leave empty is left out."""
    rows = [(_name(v), _type(v), _start(v), v.unit or "", _remark(v)) for v in variables]
    headings = ("name", "type", "start", "unit", "description")
    used = [k for k in range(len(headings)) if k == 0 or any(row[k] for row in rows)]
    table = Table(box=None, padding=(0, 1), pad_edge=False)
    for k in used:
        table.add_column(headings[k], overflow="fold", justify="right" if headings[k] == "start" else "left")
    for row in rows:
        table.add_row(*(row[k] for k in used))
    return table


def _name(variable: About) -> str:
    return variable.name + (f"[{','.join(map(str, variable.shape))}]" if variable.shape else "")


def _type(variable: About) -> str:
    """Return the type, unless it is the usual one."""
    return "" if variable.fmi_type in ("Real", "Float64") else variable.fmi_type


def _start(variable: About) -> str:
    start = variable.start
    if isinstance(start, int) and not isinstance(start, bool) and variable.literals:
        return variable.literals.get(start, str(start))
    values = start if isinstance(start, list) else [start]
    return " ".join(_text(value) for value in values if value is not None)


def _text(value: float | int | bool | str) -> str:
    """Return a value in a few digits; JSON has them all."""
    return str(value).lower() if isinstance(value, bool) else f"{value:.7g}" if isinstance(value, float) else str(value)


def _remark(variable: About) -> str:
    literals = f" ({', '.join(variable.literals.values())})" if variable.literals else ""
    return (variable.description or "") + literals

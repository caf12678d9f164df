"""A compiled model in words: what became of its equations, and in which order it is computed."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence

import casadi as ca

from cosim.dae.dae import Dae
from cosim.dae.hybrid import Assignment, Clock
from cosim.dae.symbolic import evaluate

_WIDTH = 110
_KEY = 22


def explain(dae: Dae) -> str:
    """A text of a page or two; what ``cosim export --explain`` prints."""
    lines = [f"{dae.name}: {dae.description or 'no description'}", ""]
    lines += _interface(dae) + _equations(dae) + _unknowns(dae) + _blocks(dae) + _events(dae)
    return "\n".join(lines + _initial(dae) + _aliases(dae))


def _line(key: str, text: str) -> list[str]:
    return textwrap.wrap(
        text, _WIDTH, initial_indent=key.ljust(_KEY), subsequent_indent=" " * _KEY, break_long_words=False
    )


def _items(texts: Iterable[str]) -> list[str]:
    wrapped: list[str] = []
    for text in texts:
        wrapped += textwrap.wrap(
            text, _WIDTH, initial_indent="    ", subsequent_indent="        ", break_long_words=False
        )
    return wrapped


def _interface(dae: Dae) -> list[str]:
    outputs = [p.scalar.name for p in dae.published if p.scalar.causality == "output"]
    lines = _line("inputs", _listed([s.name for s in dae.inputs]))
    lines += _line("outputs", _listed(outputs))
    free = sum(p.independent for p in dae.parameters)
    return [*lines, *_line("parameters", f"{len(dae.parameters)}, {free} of them to be set")]


def _equations(dae: Dae) -> list[str]:
    sizes = dae.sizes
    text = (
        f"{sizes.flat} flat, {sizes.after_aliases} after alias elimination, {sizes.differentiated} with derivatives of"
        " constraints"
    )
    lines = _line("equations", text) + _line("differentiation index", str(sizes.index))
    if dae.differentiated:
        lines += _line("differentiated", _count(len(dae.differentiated), "equation"))
        lines += _items(
            f"{'twice' if n == 2 else 'once' if n == 1 else f'{n} times'}: {e}" for e, n in dae.differentiated
        )
    return lines


def _unknowns(dae: Dae) -> list[str]:
    lines = _line("continuous states", str(len(dae.states)))
    lines += _items(state.name for state in dae.states)
    if dae.not_chosen:
        lines += _line("not chosen as states", _listed(dae.not_chosen, most=len(dae.not_chosen)))
    found = f"{len(dae.torn)}, found by the solver together with the states" if dae.torn else "none"
    lines += _line("torn unknowns", found)
    return lines + _items(unknown.name for unknown in dae.torn)


def _blocks(dae: Dae) -> list[str]:
    explicit = sum(block.kind == "explicit" for block in dae.blocks)
    lines = _line("blocks", f"{len(dae.blocks)}, {explicit} of them single assignments")
    numbered = enumerate(dae.coupled_blocks, 1)
    return lines + _items(f"block {number}: {block}: {_listed(block.unknowns)}" for number, block in numbered)


def _events(dae: Dae) -> list[str]:
    watched = [relation.text for relation in dae.relations if not relation.slope]
    known = [relation.text for relation in dae.relations if relation.slope]
    lines = _line("state events", f"{len(watched)}, where one of these changes its value" if watched else "none")
    lines += _items(watched)
    periodic = sum(not clock.terminal for clock in dae.clocks)
    kinds = [_count(periodic, "sample clock")] if periodic else []
    kinds += ["the end"] if len(dae.clocks) > periodic else []
    kinds += [_count(len(known), "time relation")] if known else []
    lines += _line("time events", ", ".join(kinds) or "none")
    lines += _items([*(_clock(dae, clock) for clock in dae.clocks), *known])
    lines += _line("discrete variables", _listed([s.name for s in dae.discretes if not s.name.startswith("$")]))
    lines += _items(_assignment(assignment) for assignment in dae.assignments)
    if dae.resets:
        names = list(dict.fromkeys(dae.states[reset.index].name for reset in dae.resets))
        lines += _line("reinitialised states", _listed(names))
    errors = sum(check.is_error for check in dae.checks)
    text = f"{len(dae.checks)}, {errors} of them end the simulation" if dae.checks else "none"
    return lines + _line("assertions", text)


def _assignment(assignment: Assignment) -> str:
    """Helper variables, whose names begin with a dollar sign, stand for what they are for."""
    if assignment.guard is not None:
        return f"in when-clauses: {', '.join(assignment.targets)}"
    if assignment.targets[0].startswith("$when"):
        return f"when-condition: {assignment.text.partition(' = ')[2]}"
    return assignment.text.partition(" = ")[2] if assignment.targets[0].startswith("$") else assignment.text


def _clock(dae: Dae, clock: Clock) -> str:
    if clock.terminal:
        return "when the simulation ends"
    known = {s.name() for s in ca.symvar(ca.vertcat(clock.start, clock.interval))}
    if known <= set(dae.parameter_values):
        start, interval = (float(evaluate(e, dae.parameter_values)) for e in (clock.start, clock.interval))
        return f"every {interval:g} s from {start:g} s on"
    return f"every {clock.interval} from {clock.start} on"


def _initial(dae: Dae) -> list[str]:
    lines = _line("initial system", _count(len(dae.initial_texts), "equation"))
    return lines + _items(dae.initial_texts)


def _aliases(dae: Dae) -> list[str]:
    """Variables that are one, line by line: what stays first."""
    lines = _line("eliminated aliases", str(len(dae.aliases)))
    groups: dict[str, list[str]] = {}
    for name, value in dae.aliases.items():
        plain = value.removeprefix("(-").removesuffix(")") if value.startswith("(-") else value
        groups.setdefault(plain, []).append(name if plain == value else f"-{name}")
    return lines + _items(" = ".join([kept, *names]) for kept, names in groups.items())


def _count(number: int, thing: str) -> str:
    return f"{number} {thing}{'s' * (number != 1)}"


def _listed(names: Sequence[str], most: int = 12) -> str:
    if not names:
        return "none"
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")

"""``cosim disturbance``: a seeded sequence of torque pulses as a scenario file."""

from __future__ import annotations

from pathlib import Path

from cosim.errors import InputError
from cosim.scenario import read
from cosim.scenario.disturbance import Pulses, rows, text
from cosim.units import compatible, convert, parse, quantity


def write_disturbance(
    out: Path,
    *,
    base: Path | None,
    stop: str | None,
    size: str,
    length: str,
    spacing: str,
    variation: float,
    seed: int,
) -> int:
    """Write the file and return the number of pulses."""
    pulses = Pulses(
        size=_number("--size", size, "N.m"),
        length=_number("--length", length, "s"),
        spacing=_number("--spacing", spacing, "s"),
        variation=variation,
        seed=seed,
    )
    if stop is not None:
        end = _number("--stop", stop, "s")
    elif base is not None:
        end = read(base).stop
    else:
        raise InputError("give --stop, the time up to which there are pulses, or --base, a scenario that has one")
    content = text(pulses, end, base)
    if base is not None and out.resolve() == base.resolve():
        raise InputError(f"--out would overwrite the base scenario {base}; give another file")
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        out.write_text(content, encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot write {out}: {error.strerror}") from None
    return sum(torque != 0 for _, torque in rows(pulses, end))


def _number(option: str, value: str, unit: str) -> float:
    number, found = quantity(value)
    if not compatible(found, parse(unit)):
        raise InputError(f"{option} {value}: expected a quantity in {unit}, such as 2 {unit}")
    return convert(number, found, parse(unit))

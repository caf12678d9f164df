"""``cosim calibrate``: parameters of the plant from measurements."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

import typer

from cosim.calibration import Fit, Free, Method, data_of, draw_fit, fit, linkage_model, linkage_plant, write_fit
from cosim.cli._choices import measured, table
from cosim.cli._screen import Screen, warned
from cosim.errors import InputError
from cosim.measurement import read
from cosim.units import compatible, convert, parse, quantity

NOT_MET, NOT_CONVERGED = 1, 3
"""Exit codes: something is not determined although that is required; the fit did not converge."""
_COMPONENT = "plant."
_PRIOR = re.compile(r"(?P<name>[^=]+)=(?P<mean>.+?)(?:\+-|\+/-|±)(?P<deviation>.+)")
_FREE = re.compile(r"(?P<name>[^=:]+)(?:=(?P<start>[^:]+))?(?::(?P<low>.*?)\.\.(?P<high>.*))?")


@dataclass(frozen=True)
class Request:
    """The texts of the options."""

    fit: Sequence[str]
    local: Sequence[str]
    priors: Sequence[str]
    settings: Sequence[str]
    hold_out: Sequence[Path]
    columns: Sequence[str]
    start: str | None
    stop: str | None
    robust: bool
    iterations: int
    method: Method


def calibrate_files(
    measurements: Sequence[Path], request: Request, out: Path, screen: Screen, *, require: bool, plots: bool
) -> int:
    """Fit parameters to measurements, print and write what is found; return the exit code.

    Raises `InputError` for options and files that cannot be used.
    """
    if not request.fit and not request.local:
        raise InputError("nothing to fit; say what, such as --fit d_joint --fit 'ext_load=3:0..10'")
    window = (
        None if request.start is None else _seconds(request.start, "--start"),
        None if request.stop is None else _seconds(request.stop, "--stop"),
    )
    names = measured(request.columns)
    with warned(screen):
        data = [data_of(read(path, columns=names), *window) for path in measurements]
        held_out = [data_of(read(path, columns=names), *window) for path in request.hold_out]
    picture = out.with_suffix(".png")
    for path in (out, picture) if plots else (out,):
        _check_writable(path)
    with screen.working("compiling the plant"):
        units = {p.name: p.unit for p in linkage_plant().parameters if p.type == "Real"}
        free, given, fixed = _parameters(request, units)
        model = linkage_model([f.name for f in free], given)

    def tell(iteration: int, chi: float) -> None:
        if screen.talks:
            typer.echo(f"iteration {iteration}: residuals are {chi:.4g} times the noise", err=True)

    found = fit(
        model,
        free,
        data,
        held_out=held_out,
        robust=request.robust,
        method=request.method,
        most_iterations=request.iterations,
        progress=tell,
    )
    document = write_fit(found, out, {name: (value, units.get(name, "1")) for name, value in fixed.items()})
    screen.say(describe(found))
    if plots:
        draw_fit(found, picture)
        screen.say(str(picture))
    screen.say(str(out))
    exit_code = 0
    doubts = [d.told() for d in found.uncertainty.undetermined]
    for doubt in doubts:
        screen.warn(doubt)
    if require and doubts:
        screen.error("required, but not so: all fitted parameters are determined by the data")
        exit_code = NOT_MET
    if not found.solved:
        screen.error(
            f"the fit did not converge: {found.limit} (after {found.iterations} iterations); "
            f"{out} is marked accordingly. Start nearer, give bounds or priors, or fit less at once"
        )
        exit_code = NOT_CONVERGED
    screen.document({**document, "file": str(out), "exit_code": exit_code})
    return exit_code


def describe(found: Fit) -> str:
    """Return the text that the command prints: estimates, correlation, agreement."""
    rows = [
        [e.name, e.of or "", f"{e.value:.6g}", f"{e.error:.2g}", f"{e.start:.6g}", e.unit, "yes" if e.at_bound else ""]
        for e in found.estimates
    ]
    lines = table(["parameter", "of", "value", "std. error", "start", "unit", "at bound"], rows, left=(1, 5))
    names = found.uncertainty.names
    if len(names) > 1:
        values = found.uncertainty.correlation
        correlation = [[name, *(f"{v:.2f}" for v in row[: k + 1])] for k, (name, row) in enumerate(
            zip(names, values.tolist(), strict=True)
        )]  # fmt: skip
        filled = [row + [""] * (len(names) + 1 - len(row)) for row in correlation]
        lines += ["", *table(["correlation", *names], filled)]
    agreement = [
        [
            a.name,
            "held out" if a.held_out else "fitted",
            f"{a.current_rmse:.4g}",
            f"{a.noise:.4g}",
            "" if a.torque_rmse is None else f"{a.torque_rmse:.4g}",
            str(a.samples),
        ]
        for a in found.agreements
    ]
    head = ["measurement", "", "RMSE [A]", "noise [A]", "RMSE [N.m]", "samples"]
    lines += ["", *table(head, agreement, left=(1,))]
    if found.synthetic:
        lines.append("note: the data are synthetic: computed, not measured")
    return "\n".join([*lines, *(f"note: {note}" for note in dict.fromkeys(found.notes))])


def _check_writable(path: Path) -> None:
    """Raise InputError if a file cannot be written: before the work of which it is to tell."""
    existed = path.exists()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("ab"):
            pass
        if not existed:
            path.unlink()
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}", file=path) from error


def _parameters(request: Request, units: Mapping[str, str]) -> tuple[list[Free], dict[str, float], dict[str, float]]:
    """Return what to fit, all values that differ from the model's, and of these those that stay."""
    priors = dict(_prior(text, units) for text in request.priors)
    free: list[Free] = []
    given: dict[str, float] = {}
    for option, texts in (("--fit", request.fit), ("--local", request.local)):
        for text in texts:
            found = _FREE.fullmatch(text)
            if found is None:
                raise InputError(f"{option} {text}: write NAME, NAME=START, NAME:LOW..HIGH or NAME=START:LOW..HIGH")
            name = _known(found["name"], units, f"{option} {text}")
            if name in (f.name for f in free):
                raise InputError(f"{option} {text}: {name} is to be fitted already")
            start, low, high = (
                _number(found[key], name, units, f"{option} {text}") if found[key] else None
                for key in ("start", "low", "high")
            )
            if start is not None:
                given[name] = start
            free.append(Free(name, low, high, priors.pop(name, None), local=option == "--local"))
    if priors:
        raise InputError(f"--prior {next(iter(priors))}: it is not fitted; add --fit {next(iter(priors))}")
    fixed: dict[str, float] = {}
    for text in request.settings:
        before, sign, value = (part.strip() for part in text.partition("="))
        if not sign or not value:
            raise InputError(f"--set {text}: write NAME=VALUE, such as --set gear.eta_wg=0.7")
        name = _known(before, units, f"--set {text}")
        if name in (f.name for f in free):
            raise InputError(f"--set {text}: {name} is to be fitted; give its start with --fit {name}={value}")
        fixed[name] = _number(value, name, units, f"--set {text}")
    return free, given | fixed, fixed


def _prior(text: str, units: Mapping[str, str]) -> tuple[str, tuple[float, float]]:
    found = _PRIOR.fullmatch(text)
    if found is None:
        raise InputError(f"--prior {text}: write NAME=VALUE+-DEVIATION, such as --prior 'gear.eta_wg=0.7+-0.03'")
    name = _known(found["name"], units, f"--prior {text}")
    mean, deviation = (_number(found[key], name, units, f"--prior {text}") for key in ("mean", "deviation"))
    return name, (mean, deviation)


def _known(name: str, units: Mapping[str, str], option: str) -> str:
    """The parameter's name in the plant, with or without the scenario's name of the plant in front."""
    plain = name.strip().removeprefix(_COMPONENT)
    if plain not in units:
        near = get_close_matches(plain, list(units), n=3)
        hint = f"; did you mean {' or '.join(near)}?" if near else ""
        raise InputError(f"{option}: the plant has no parameter '{plain}' that is a number{hint}")
    return plain


def _number(text: str, name: str, units: Mapping[str, str], option: str) -> float:
    """A number, in the parameter's unit if it carries none."""
    try:
        number, unit = quantity(text.strip())
    except InputError:
        raise InputError(f"{option}: '{text.strip()}' is not a number, with or without a unit") from None
    if unit.text == "1":
        return number
    wanted = parse(units[name])
    if not compatible(unit, wanted):
        raise InputError(f"{option}: {name} is in {units[name]}, not in {unit.text}")
    return convert(number, unit, wanted)


def _seconds(text: str, option: str) -> float:
    return _number(text, "time", {"time": "s"}, f"{option} {text}")

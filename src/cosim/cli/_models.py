"""Commands that make FMUs of Modelica models, or linearize them.

What a command needs is imported when it runs, so that ``--help`` is quick.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cosim.cli._options import Fmi, Json, ModelicaFile, ModelName, Platform, Quiet, Sources, StrictUnits
from cosim.cli._screen import Screen, reporting, warned


def build(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="[NAME...]", help="Built-in plants and controllers; default all.")
    ] = None,
    *,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Where to put the FMUs.")] = None,
    platform: Platform = "host",
    fmi: Fmi = "3.0",
    sources: Sources = None,
    strict_units: StrictUnits = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Build the FMUs of the built-in plants and controllers."""
    screen = Screen(quiet=quiet, as_json=as_json)
    with reporting(screen):
        from cosim.cli._builtin import build_all, check_target

        choice = check_target(platform, fmi)
        with warned(screen), screen.working("building FMUs"):
            paths = build_all(names or None, out, choice, platform, strict_units=strict_units, with_sources=sources)
        screen.document({"fmus": [str(path) for path in paths]})
        for path in paths:
            screen.say(str(path))


def export(
    file: ModelicaFile,
    model: ModelName,
    *,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Where to put Model.fmu.")] = Path(),
    explain: Annotated[bool, typer.Option("--explain", help="Also print how the equations were solved for.")] = False,
    platform: Platform = "host",
    fmi: Fmi = "3.0",
    fixed_step: Annotated[
        str | None,
        typer.Option("--fixed-step", metavar="TIME", help="Take steps of this length, for hardware in the loop."),
    ] = None,
    sources: Sources = None,
    strict_units: StrictUnits = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Compile a Modelica model into an FMU."""
    screen = Screen(quiet=quiet, as_json=as_json)
    with reporting(screen):
        from cosim.cli._builtin import check_target, export_model, step_of

        choice = check_target(platform, fmi)
        with warned(screen) as found, screen.working(f"compiling {model}"):
            paths, text = export_model(
                file,
                model,
                out,
                choice,
                platform,
                strict_units=strict_units,
                explain=explain,
                with_sources=sources,
                fixed_step=step_of(fixed_step),
            )
        document: dict[str, object] = {"fmu": str(paths[0]), "fmus": [str(path) for path in paths]}
        screen.document(document | {"explanation": text, "warnings": found})
        if text is not None:
            screen.say(text)
        for path in paths:
            screen.say(str(path))


def linearize(
    file: ModelicaFile,
    model: ModelName,
    *,
    at: Annotated[
        str,
        typer.Option(metavar="TIME|initial|steady", help="Operating point: a time such as '2.5 s', or one of these."),
    ] = "initial",
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help="Set a parameter. Repeatable.")
    ] = None,
    inputs: Annotated[
        list[str] | None, typer.Option("--input", metavar="NAME=VALUE", help="Set an input. Repeatable.")
    ] = None,
    outputs: Annotated[
        list[str] | None,
        typer.Option("--output", metavar="NAME", help="Take this variable as an output, not the model's. Repeatable."),
    ] = None,
    steady_except: Annotated[
        list[str] | None,
        typer.Option(metavar="STATE", help="Let this state, such as an angle, keep its value. Repeatable."),
    ] = None,
    settle: Annotated[
        str | None, typer.Option(metavar="TIME", help="Simulate this long before the steady state is searched.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Write Model_linear.json and Model_bode.png there.")
    ] = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Linearize a Modelica model: A, B, C, D, poles, Bode picture."""
    screen = Screen(quiet=quiet, as_json=as_json)
    with reporting(screen):
        from cosim.cli._linearize import linearize_model

        with warned(screen) as found, screen.working(f"linearizing {model}"):
            document = linearize_model(
                file,
                model,
                screen,
                at=at,
                settings=settings or [],
                inputs=inputs or [],
                outputs=outputs or [],
                steady_except=steady_except or [],
                settle=settle,
                out=out,
            )
        screen.document(document | {"warnings": found})

"""Commands on any FMU.

What a command needs is imported when it runs, so that ``--help`` is quick.
"""

from __future__ import annotations

from typing import Annotated

import typer

from cosim.cli._options import AnyFmu, Json, Quiet
from cosim.cli._screen import Screen, reporting


def info(
    fmu: AnyFmu,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Show what an FMU is: interfaces, variables, capabilities."""
    screen = Screen(quiet=quiet, as_json=as_json)
    with reporting(screen):
        from cosim.cli._info import show

        show(fmu, screen)


def check(
    fmu: AnyFmu,
    *,
    strict: Annotated[bool, typer.Option("--strict", help="Exit with 2 for warnings, too.")] = False,
    run: Annotated[
        bool, typer.Option("--run/--no-run", help="Also run the FMU's binary, in a process of its own.")
    ] = True,
    timeout: Annotated[
        str, typer.Option(metavar="TIME", help="How long each rule that runs the FMU may take.")
    ] = "30 s",
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Judge an FMU: archive, schema, semantics, binaries, runs. Exits with 2 if it has errors."""
    screen = Screen(quiet=quiet, as_json=as_json)
    with reporting(screen):
        from cosim.cli._times import time_of

        longest = time_of("--timeout", timeout)
        from cosim.cli._check import check_fmu

        raise typer.Exit(check_fmu(fmu, screen, strict=strict, run=run, timeout=longest))

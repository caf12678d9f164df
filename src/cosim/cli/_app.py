"""The command line: its commands, in the order in which ``--help`` lists them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

import typer

from cosim import __version__
from cosim.cli import _fmus, _measurements, _models, _results, _scenarios
from cosim.cli._screen import INTERRUPTED

app = typer.Typer(
    name="cosim",
    help="Simulate windscreen wiper drives, and any other FMUs, from CSV scenarios; export Modelica models as FMUs.",
    epilog="Exit codes: 0 done, 1 a requirement is not met, 2 the input is wrong, 3 a build or a simulation failed, "
    "130 interrupted.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"max_content_width": 100},
)

app.command(name="run")(_scenarios.run)
app.command(name="build")(_models.build)
app.command(name="info")(_fmus.info)
app.command(name="check")(_fmus.check)
app.command(name="export")(_models.export)
app.command(name="export-ssp")(_scenarios.export_ssp)
app.command(name="disturbance")(_scenarios.disturbance)
app.command(name="linearize")(_models.linearize)
app.command(name="thesis")(_results.thesis)
app.command(name="compare")(_results.compare)
app.command(name="calibrate")(_results.calibrate)
app.command(name="score")(_results.score)
app.add_typer(_measurements.app)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line with ``arguments`` (default: the process's) and exit the process with its code."""
    try:
        app(args=None if arguments is None else list(arguments), prog_name="cosim")
    except KeyboardInterrupt:
        raise SystemExit(INTERRUPTED) from None


def _show_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"cosim {__version__}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """Take the options that stand before the command."""

"""Commands on scenarios.

What a command needs is imported when it runs, so that ``--help`` is quick.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cosim.cli._options import Json, Plots, Quiet
from cosim.cli._screen import Screen, reporting


def run(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Scenario files.", show_default=False)],
    *,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Put the results of x.csv into DIR/x/.")] = Path("results"),
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="Set a parameter, such as 'plant.ext_load=4 N.m', or stop, sample_time, output_interval, tolerance, "
            "system or controller; wins over the file. Repeatable.",
        ),
    ] = None,
    parameters: Annotated[
        list[Path] | None,
        typer.Option("--params", metavar="FILE", help="Parameters that cosim calibrate has written. Repeatable."),
    ] = None,
    faults: Annotated[
        list[str] | None,
        typer.Option(
            "--fault",
            metavar="TEXT",
            help="Do a fault to an input, such as 'i_motor bias 0.5 A from 2 s to 5 s', beside those of the file. "
            "Repeatable.",
        ),
    ] = None,
    checkpoints: Annotated[
        list[str] | None,
        typer.Option(
            "--checkpoint",
            metavar="TIME",
            help="Save the whole state at this time, such as '2 s', into checkpoint_2s.cosim beside the results. "
            "Repeatable.",
        ),
    ] = None,
    resume: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Go on from such a file; the results are those of an uninterrupted run."),
    ] = None,
    plots: Plots = True,
    coupling_error: Annotated[
        bool,
        typer.Option(
            "--coupling-error/--no-coupling-error",
            help="Where continuous signals are exchanged, estimate the error of that by a second run.",
        ),
    ] = True,
    isolate: Annotated[
        str,
        typer.Option(
            metavar="auto|always|never",
            help="Simulate in a process of its own, which may crash or hang alone; auto: if an FMU was not built here.",
        ),
    ] = "auto",
    call_timeout: Annotated[
        str, typer.Option(metavar="TIME", help="How long one call of an FMU may take in such a process.")
    ] = "60 s",
    memory_limit: Annotated[
        str | None,
        typer.Option(
            metavar="SIZE", help="Memory that such a process may have, such as '4 GB'; default: the machine's."
        ),
    ] = None,
    timing: Annotated[
        bool,
        typer.Option("--explain-timing", help="Do not run; tell who is computed when, what travels, and each delay."),
    ] = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Simulate scenarios one after another. Writes results.csv, results.parquet, summary.json and plots."""
    screen = Screen(quiet=quiet, as_json=as_json)
    with reporting(screen):
        from cosim.cli._isolation import isolation, prepare

        isolated = isolation(isolate, call_timeout, memory_limit)
        prepare(files, isolated, settings or [])
        from cosim.cli._checkpoints import Checkpoints
        from cosim.cli._run import Options, explain_files, run_files
        from cosim.errors import InputError

        options = Options.of(settings, parameters, faults)
        saving = Checkpoints.of(checkpoints, resume, len(files))
        if timing and saving != Checkpoints():
            raise InputError("--explain-timing does not run anything; leave out --checkpoint and --resume")
        if timing:
            raise typer.Exit(explain_files(files, options, screen, isolated))
        raise typer.Exit(
            run_files(files, out, options, screen, isolated, plots=plots, coupling_error=coupling_error, saving=saving)
        )


def export_ssp(
    file: Annotated[Path, typer.Argument(metavar="SCENARIO", help="Scenario file.", show_default=False)],
    *,
    out: Annotated[
        Path | None, typer.Option(metavar="X.ssp", help="The SSP to write; default: the scenario's name, here.")
    ] = None,
    ssp: Annotated[str, typer.Option("--ssp", metavar="1.0|2.0", help="Version of the SSP standard.")] = "1.0",
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help="As for 'cosim run'. Repeatable.")
    ] = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Write a scenario's system as an SSP. With FMUs, parameters, and X_ssp.csv, a scenario that runs it."""
    screen = Screen(quiet=quiet, as_json=as_json)
    with reporting(screen):
        from cosim.cli._export_ssp import export_ssp as write_ssp

        written, beside = write_ssp(file, out, ssp, settings or [], screen)
        screen.document({"ssp": str(written), "scenario": str(beside)})
        screen.say(f"{written}\n{beside}")


def disturbance(
    *,
    out: Annotated[Path, typer.Option(metavar="FILE", help="Scenario file to write.", show_default=False)],
    base: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Scenario without rows, whose '#' lines the new one gets.")
    ] = None,
    stop: Annotated[
        str | None, typer.Option(metavar="TIME", help="No pulse after this time; default: the base's stop.")
    ] = None,
    size: Annotated[str, typer.Option(metavar="TORQUE", help="Mean torque of a pulse.")] = "5 N.m",
    length: Annotated[str, typer.Option(metavar="TIME", help="Mean duration of a pulse.")] = "0.3 s",
    spacing: Annotated[str, typer.Option(metavar="TIME", help="Mean time from one pulse to the next.")] = "3 s",
    variation: Annotated[float, typer.Option(help="By how much of itself each of these may be off.")] = 0.2,
    seed: Annotated[int, typer.Option(help="Begin of the random numbers; the same pulses for one seed.")] = 1,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Write a scenario with pulses of torque on the load. They brake and accelerate by turns; a seed varies them."""
    screen = Screen(quiet=quiet, as_json=as_json)
    with reporting(screen):
        from cosim.cli._disturbance import write_disturbance

        count = write_disturbance(
            out,
            base=base,
            stop=stop,
            size=size,
            length=length,
            spacing=spacing,
            variation=variation,
            seed=seed,
        )
        screen.document({"scenario": str(out), "pulses": count})
        screen.say(f"{out}: {count} pulses")

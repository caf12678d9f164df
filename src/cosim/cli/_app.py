"""The commands and their options. What a command needs is imported when it runs, so that ``--help`` is quick."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from cosim import __version__
from cosim.cli import _measurements
from cosim.cli._screen import INTERRUPTED, Screen, reporting, warned

app = typer.Typer(
    name="cosim",
    help="Simulate windscreen wiper drives, and any other FMUs, from CSV scenarios; export Modelica models as FMUs.",
    epilog="Exit codes: 0 done, 1 a requirement is not met, 2 the input is wrong, 3 a build or a simulation failed, "
    "130 interrupted.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print errors only.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON document on stdout instead of text.")]
Platform = Annotated[
    str,
    typer.Option(
        metavar="host|all|LIST",
        help="Platforms of the FMU's binaries: this machine's, all, or names such as x86_64-linux,x86_64-windows.",
    ),
]
StrictUnits = Annotated[
    bool, typer.Option("--strict-units", help="Refuse a model whose units do not fit, instead of a warning.")
]
Sources = Annotated[
    bool | None,
    typer.Option(
        "--sources/--no-sources",
        help="Put the C sources into the FMU; by default into one for a single platform.",
        show_default=False,
    ),
]
Fmi = Annotated[str, typer.Option(metavar="3.0|2.0|both", help="FMI version; an FMI 2.0 file ends in .fmi2.fmu.")]

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


@app.command()
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
    plots: Annotated[bool, typer.Option("--plots/--no-plots", help="Draw PNG plots.")] = True,
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
    """Simulate scenarios one after another; write results.csv, results.parquet, summary.json and plots."""
    screen = Screen(quiet=quiet, as_json=as_json)
    with reporting(screen):
        from cosim.cli._isolation import isolation, prepare

        isolated = isolation(isolate, call_timeout, memory_limit)
        prepare(files, isolated, settings or [])
        from cosim.cli._run import Options, explain_files, run_files

        options = Options.of(settings, parameters)
        if timing:
            raise typer.Exit(explain_files(files, options, screen, isolated))
        raise typer.Exit(run_files(files, out, options, screen, isolated, plots=plots))


@app.command()
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


@app.command()
def info(
    fmu: Annotated[str, typer.Argument(metavar="X.fmu", help="Path of an FMU, or name of a built-in one.")],
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Show what an FMU is and which inputs, outputs and parameters it has."""
    screen = Screen(quiet=quiet, as_json=as_json)
    with reporting(screen):
        from cosim.cli._info import show

        show(fmu, screen)


@app.command(name="check")
def check_command(
    fmu: Annotated[str, typer.Argument(metavar="X.fmu", help="Path of an FMU, or name of a built-in one.")],
    *,
    strict: Annotated[bool, typer.Option("--strict", help="Exit with 2 for warnings, too.")] = False,
    run: Annotated[
        bool, typer.Option("--run/--no-run", help="Also run the FMU's binary, in a process of its own.")
    ] = True,
    timeout: Annotated[
        float, typer.Option(metavar="SECONDS", min=0.1, help="How long each rule that runs the FMU may take.")
    ] = 30.0,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Judge an FMU: archive, schema, semantics, binaries, and how it runs; exit with 2 if it has errors."""
    screen = Screen(quiet=quiet, as_json=as_json)
    with reporting(screen):
        from cosim.cli._check import check_fmu

        raise typer.Exit(check_fmu(fmu, screen, strict=strict, run=run, timeout=timeout))


@app.command()
def export(
    file: Annotated[Path, typer.Argument(metavar="FILE.mo", help="Modelica file.", show_default=False)],
    model: Annotated[str, typer.Argument(metavar="Package.Model", help="Full name of the model.", show_default=False)],
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


@app.command(name="export-ssp")
def export_ssp_command(
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
    """Write a scenario's system with its FMUs and parameters as an SSP, and X_ssp.csv, a scenario that runs it."""
    screen = Screen(quiet=quiet, as_json=as_json)
    with reporting(screen):
        from cosim.cli._export_ssp import export_ssp

        written, beside = export_ssp(file, out, ssp, settings or [], screen)
        screen.document({"ssp": str(written), "scenario": str(beside)})
        screen.say(f"{written}\n{beside}")


@app.command()
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
    """Write a scenario in which the load is braked and accelerated by turns, in pulses that a seed varies."""
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


@app.command(name="linearize")
def linearize_command(
    file: Annotated[Path, typer.Argument(metavar="FILE.mo", help="Modelica file.", show_default=False)],
    model: Annotated[str, typer.Argument(metavar="Package.Model", help="Full name of the model.", show_default=False)],
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
    """Linearize a Modelica model: A, B, C, D at an operating point, poles, and a Bode picture."""
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


@app.command()
def thesis(
    *,
    out: Annotated[Path, typer.Option(metavar="DIR", help="The folder thesis/ is made in.")] = Path("results"),
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="Read table 4.1 otherwise than a plot shows it, as cosim score does: 'late=20 ms'. Repeatable.",
        ),
    ] = None,
    measured: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Measured torque for figure 3.6: .csv with 'time [s]' and 'torque [N.m]', .xlsx, .mat, .mf4.",
        ),
    ] = None,
    sensitivity: Annotated[
        bool, typer.Option("--sensitivity", help="Also vary what the source leaves open, in a thousand runs.")
    ] = False,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Simulate what the source shows, and draw its figures and table 4.1."""
    screen = Screen(quiet=quiet, as_json=as_json)
    with reporting(screen):
        from cosim.cli._thesis import reproduce_thesis

        reproduce_thesis(out / "thesis", settings or [], measured, screen, sensitive=sensitivity)


@app.command(name="compare")
def compare_command(
    result: Annotated[Path, typer.Argument(metavar="RESULT", help="Folder written by cosim run.", show_default=False)],
    measurements: Annotated[
        list[Path],
        typer.Argument(metavar="MEASUREMENT...", help="Files: .xlsx, .mat, .csv or .mf4.", show_default=False),
    ],
    *,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Where to put comparison.json and the pictures; default RESULT.")
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="quantity, align (correlation, onset, angle, none), smoothing, start, stop, tube_x, tube_y or "
            "tube_y_relative, such as 'tube_x=50 ms'. Repeatable.",
        ),
    ] = None,
    columns: Annotated[
        list[str] | None,
        typer.Option("--column", metavar="SIGNAL=COLUMN", help="Take this column of the result. Repeatable."),
    ] = None,
    require: Annotated[bool, typer.Option("--require", help="End with 1 unless the result stays in the tube.")] = False,
    limits: Annotated[
        list[str] | None,
        typer.Option(
            "--limit",
            metavar="FIGURE=NUMBER",
            help="End with 1 if a figure is larger (correlation: smaller), such as rmse_nm=1.5. Repeatable.",
        ),
    ] = None,
    plots: Annotated[bool, typer.Option("--plots/--no-plots", help="Draw PNG plots.")] = True,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Lay measured torque over a simulated one: figures of the difference, a tube with a verdict, pictures."""
    screen = Screen(quiet=quiet, as_json=as_json)
    with reporting(screen):
        from cosim.cli._compare import compare_files

        code = compare_files(
            result, measurements, out, settings or [], columns or [], limits or [], screen, require=require, plots=plots
        )
        raise typer.Exit(code)


@app.command(name="score")
def score_command(
    results: Annotated[
        list[Path], typer.Argument(metavar="RESULT...", help="Folders written by cosim run.", show_default=False)
    ],
    *,
    vibration: Annotated[
        bool, typer.Option("--vibration", help="Measure torque, current, rates, shocks, spectrum and power instead.")
    ] = False,
    against: Annotated[
        Path | None, typer.Option(metavar="BASELINE", help="Give the ratios of the vibration to this result's.")
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set", metavar="NAME=VALUE", help="Choose where the source is open, such as 'early=50 ms'. Repeatable."
        ),
    ] = None,
    columns: Annotated[
        list[str] | None,
        typer.Option("--column", metavar="SIGNAL=COLUMN", help="Take this column for a signal. Repeatable."),
    ] = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Score results by the criteria of the thesis: predicted parks and turning points; or measure their vibration."""
    screen = Screen(quiet=quiet, as_json=as_json)
    with reporting(screen):
        if vibration or against is not None:
            from cosim.cli._vibration import measure_results

            raise typer.Exit(measure_results(results, against, settings or [], columns or [], screen))
        from cosim.cli._score import score_results

        raise typer.Exit(score_results(results, settings or [], columns or [], screen))

"""Commands on results and measurements, and the reproduction of the thesis.

What a command needs is imported when it runs, so that ``--help`` is quick.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from cosim.cli._options import Json, MeasuredColumns, Plots, Quiet
from cosim.cli._screen import Screen, reporting


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
    """Simulate what the source shows; draw figures and table 4.1."""
    screen = Screen(quiet=quiet, as_json=as_json)
    with reporting(screen):
        from cosim.cli._thesis import reproduce_thesis

        reproduce_thesis(out / "thesis", settings or [], measured, screen, sensitive=sensitivity)


def compare(
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
            help="quantity, align (correlation, onset, angle, none), smoothing (moving_average, zero_phase, none), "
            "torque_zero (onset, line), start, stop, lag_most, tube_x, tube_y or tube_y_relative, "
            "such as 'tube_x=50 ms'. Repeatable.",
        ),
    ] = None,
    columns: Annotated[
        list[str] | None,
        typer.Option("--column", metavar="SIGNAL=COLUMN", help="Take this column of the result. Repeatable."),
    ] = None,
    measured_columns: MeasuredColumns = None,
    require: Annotated[bool, typer.Option("--require", help="End with 1 unless the result stays in the tube.")] = False,
    limits: Annotated[
        list[str] | None,
        typer.Option(
            "--limit",
            metavar="FIGURE=NUMBER",
            help="End with 1 if a figure is larger (correlation: smaller), such as rmse_nm=1.5. Repeatable.",
        ),
    ] = None,
    plots: Plots = True,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Compare a result with measurements: figures, tube, pictures."""
    screen = Screen(quiet=quiet, as_json=as_json)
    with reporting(screen):
        from cosim.cli._compare import compare_files

        code = compare_files(
            result,
            measurements,
            out,
            settings or [],
            columns or [],
            measured_columns or [],
            limits or [],
            screen,
            require=require,
            plots=plots,
        )
        raise typer.Exit(code)


def calibrate(
    measurements: Annotated[
        list[Path],
        typer.Argument(metavar="MEASUREMENT...", help="Files: .xlsx, .mat, .csv or .mf4.", show_default=False),
    ],
    *,
    fitted: Annotated[
        list[str] | None,
        typer.Option(
            "--fit",
            metavar="NAME[=START][:LOW..HIGH]",
            help="Fit this parameter of the plant, such as 'ext_load=3:0..10'; numbers in its unit or with one. "
            "Repeatable.",
        ),
    ] = None,
    local: Annotated[
        list[str] | None,
        typer.Option("--local", metavar="NAME...", help="As --fit, but each measurement has its own value."),
    ] = None,
    priors: Annotated[
        list[str] | None,
        typer.Option(
            "--prior", metavar="NAME=VALUE+-DEVIATION", help="What is known of a fitted parameter. Repeatable."
        ),
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="A parameter that is not fitted. Repeatable."),
    ] = None,
    hold_out: Annotated[
        list[Path] | None,
        typer.Option("--hold-out", metavar="FILE", help="Predict this measurement, do not fit it. Repeatable."),
    ] = None,
    measured_columns: MeasuredColumns = None,
    start: Annotated[
        str | None, typer.Option(metavar="TIME", help="Fit from here on; default: from where the motor is switched on.")
    ] = None,
    stop: Annotated[str | None, typer.Option(metavar="TIME", help="Fit up to here; default: for 7 s.")] = None,
    robust: Annotated[bool, typer.Option("--robust", help="Let outliers count less.")] = False,
    iterations: Annotated[int, typer.Option("--iterations", min=0, metavar="N", help="At most so many.")] = 200,
    method: Annotated[
        Literal["shooting", "collocation"],
        typer.Option(help="How to search: shooting is the faster one; collocation leaves it to IPOPT."),
    ] = "shooting",
    out: Annotated[Path, typer.Option(metavar="FILE", help="The parameter file, for cosim run --params.")] = Path(
        "calibrated.json"
    ),
    require: Annotated[
        bool, typer.Option("--require", help="End with 1 unless the data determine all that is fitted.")
    ] = False,
    plots: Plots = True,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Fit parameters of the linkage's plant to measurements.

    These are the motor current and, if there is one, the torque; cosim run --params takes what is found.
    """
    screen = Screen(quiet=quiet, as_json=as_json)
    with reporting(screen):
        from cosim.cli._calibrate import Request, calibrate_files

        request = Request(
            fit=fitted or [],
            local=local or [],
            priors=priors or [],
            settings=settings or [],
            hold_out=hold_out or [],
            columns=measured_columns or [],
            start=start,
            stop=stop,
            robust=robust,
            iterations=iterations,
            method=method,
        )
        raise typer.Exit(calibrate_files(measurements, request, out, screen, require=require, plots=plots))


def score(
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
    """Score results by the thesis's criteria, or their vibration. The criteria: predicted parks and turning points."""
    screen = Screen(quiet=quiet, as_json=as_json)
    with reporting(screen):
        if vibration or against is not None:
            from cosim.cli._vibration import measure_results

            raise typer.Exit(measure_results(results, against, settings or [], columns or [], screen))
        from cosim.cli._score import score_results

        raise typer.Exit(score_results(results, settings or [], columns or [], screen))

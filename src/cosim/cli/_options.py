"""Arguments and options that several commands have, worded once."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

ModelicaFile = Annotated[Path, typer.Argument(metavar="FILE.mo", help="Modelica file.", show_default=False)]
ModelName = Annotated[str, typer.Argument(metavar="Package.Model", help="Full name of the model.", show_default=False)]
AnyFmu = Annotated[str, typer.Argument(metavar="X.fmu", help="Path of an FMU, or name of a built-in one.")]
Plots = Annotated[bool, typer.Option("--plots/--no-plots", help="Draw PNG plots.")]
MeasuredColumns = Annotated[
    list[str] | None,
    typer.Option(
        "--measured-column",
        metavar="QUANTITY=NAME",
        help="Take this column of CSV or MDF files as time, torque, speed, current or voltage. Repeatable.",
    ),
]
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

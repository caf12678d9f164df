"""``cosim measurements``: what measurement files hold, and stand-in data for them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

import typer

from cosim.cli._options import Json, MeasuredColumns, Quiet
from cosim.cli._screen import Screen, reporting, warned

app = typer.Typer(
    name="measurements",
    help="Show measured torque, or make stand-in data for it.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@app.command(name="show")
def show_command(
    files: Annotated[
        list[Path], typer.Argument(metavar="FILE...", help="Files: .xlsx, .mat, .csv or .mf4.", show_default=False)
    ],
    *,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Draw each one here, smoothed by both methods.")
    ] = None,
    measured_columns: MeasuredColumns = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Show what measurements hold, and what was mended. Also where the motion begins by each method."""
    screen = Screen(quiet=quiet, as_json=as_json)
    with reporting(screen):
        _show(files, out, measured_columns or [], screen)


@app.command(name="synthesize")
def synthesize_command(
    *,
    out: Annotated[Path, typer.Option(metavar="DIR", help="Where to put the eight workbooks.")] = Path("synthetic"),
    seed: Annotated[int, typer.Option(help="Seed of the noise.")] = 1,
    rows: Annotated[int, typer.Option(help="Samples of 2 ms in each workbook.")] = 50_000,
    law: Annotated[
        Literal["naive", "simple"],
        typer.Option(help="Law of the load: the source's naive one, or equation 3.1, which a fit assumes."),
    ] = "naive",
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """Write eight synthetic workbooks in the supplier's layout. They are computed with known parameters, and marked."""
    screen = Screen(quiet=quiet, as_json=as_json)
    with reporting(screen):
        from cosim.cli._builtin import locate
        from cosim.engine import Fmu
        from cosim.measurement import synthesize

        with warned(screen), screen.working("getting the FMU ready"):
            plant = Fmu.read(locate("linkage"))
        with plant:
            paths = synthesize(out, plant, seed=seed, rows=rows, naive_load=law == "naive", told=screen.say)
        screen.say(f"{len(paths)} synthetic workbooks in {out}: no measurements")
        screen.document({"synthetic": True, "files": [str(path) for path in paths]})


def _show(files: Sequence[Path], out: Path | None, columns: Sequence[str], screen: Screen) -> None:
    from cosim.cli._choices import measured, pictures, table
    from cosim.measurement import Inspection, draw_smoothing, inspect

    names = measured(columns)
    found: list[Inspection] = []
    for path in files:
        with warned(screen):
            found.append(inspect(path, names))
    head = ["", *(each.measurement.name for each in found)]
    rows = [[label, *(each.rows()[label] for each in found)] for label in found[0].rows()]
    screen.say("\n".join(table(head, rows)))
    if out is not None:
        for each, picture in zip(found, pictures(out, "", files), strict=True):
            draw_smoothing(each.measurement, picture)
            screen.say(str(picture))
    screen.document({"measurements": [each.to_dict() for each in found]})

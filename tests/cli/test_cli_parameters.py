"""``cosim run --params``: values from parameter files, between those of the scenario and those of ``--set``."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import Result

Cosim = Callable[..., Result]


@pytest.fixture
def fitted(tmp_path: Path) -> Path:
    path = tmp_path / "fitted.json"
    entry = {"name": "plant.ext_load", "value": 4.5, "unit": "N.m", "provenance": "fitted to dry.xlsx"}
    path.write_text(json.dumps({"parameters": [entry]}))
    return path


def loads(cosim: Cosim, scenario: Path, *options: object) -> tuple[object, object]:
    """The load of a run, and where it is said to come from."""
    done = cosim("run", scenario, "--no-plots", *options)
    assert done.exit_code == 0, done.output
    (summary,) = Path("results").rglob("summary.json")
    entry = json.loads(summary.read_text())["parameters"]["plant.ext_load"]
    return entry["value"], entry["provenance"]


def test_the_scenario_the_files_and_the_options_win_in_this_order(
    cosim: Cosim, scenario: Path, fitted: Path, simulated: list[dict[str, object]]
) -> None:
    scenario.write_text(scenario.read_text().replace("# stop", "# set: plant.ext_load = 2 N.m\n# stop"))
    assert loads(cosim, scenario)[0] == 2.0
    assert loads(cosim, scenario, "--params", fitted) == (4.5, "fitted to dry.xlsx")
    later = Path("later.json")
    later.write_text('{"parameters": [{"name": "plant.ext_load", "value": 5, "unit": "N.m"}]}')
    assert loads(cosim, scenario, "--params", fitted, "--params", later) == (5.0, "set by later.json")
    value, provenance = loads(cosim, scenario, "--set", "plant.ext_load=6 N.m", "--params", fitted)
    assert (value, provenance) == (6.0, "set by --set")
    assert [asked["parameters"] for asked in simulated] == [{"ext_load": load} for load in (2.0, 4.5, 5.0, 6.0)]


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        (
            '{"name": "plant.ext_laod", "value": 4}',
            "unknown parameter 'plant.ext_laod', did you mean 'plant.ext_load'?; parameters are plant.ext_load, ",
        ),
        ('{"name": "motor.R", "value": 4}', "unknown parameter 'motor.R'; parameters are plant.ext_load, plant.i_max"),
        (
            '{"name": "plant.ext_load", "value": 4, "unit": "V"}',
            "'4 V' is in V, 'plant.ext_load' is in N.m; write for example 4 N.m",
        ),
        (
            '{"name": "plant.ext_load", "value": "much"}',
            "'plant.ext_load': 'much' is not a number with a unit; write it like 20 ms or 4.5 N.m",
        ),
        (
            '{"name": "plant.ext_load"}',
            'entry 1, plant.ext_load: "value" is None; a finite number or a text is expected',
        ),
    ],
)
def test_a_parameter_that_the_plant_does_not_take(cosim: Cosim, scenario: Path, entry: str, message: str) -> None:
    Path("p.json").write_text(f'{{"parameters": [{entry}]}}')
    done = cosim("run", scenario, "--params", "p.json")
    assert done.exit_code == 2
    assert done.stderr.startswith(f"error: p.json: {message}")

"""The solver in the FMUs against the published solutions of stiff problems, and against what they conserve.

The error of a component is measured as the solver measures it: against its size plus its nominal value.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest

from cosim.fmu import compile_model, export

TESTS = Path(__file__).parents[1]

STIFF = TESTS / "models" / "Stiff"
PROBLEMS: dict[str, dict[str, Any]] = tomllib.loads((STIFF / "reference.toml").read_text(encoding="utf-8"))
TOLERANCES = (1e-4, 1e-6, 1e-8)

Run = Callable[..., Any]


@pytest.fixture(scope="session")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Simulate a problem to its end with fmpy; ``rows`` equidistant rows after the first."""
    pytest.importorskip("rumoca")
    folder = tmp_path_factory.mktemp("stiff")

    @cache
    def built(name: str) -> Path:
        return export(STIFF / f"{name}.mo", f"Stiff.{name}", folder)

    @cache
    def run(name: str, tolerance: float, rows: int = 1) -> Any:  # noqa: ANN401 - a structured array
        stop = PROBLEMS[name]["stop"]
        return fmpy.simulate_fmu(
            str(built(name)), stop_time=stop, output_interval=stop / rows, relative_tolerance=tolerance
        )

    run.description = cache(lambda name: fmpy.read_model_description(str(built(name))))  # type: ignore[attr-defined]
    return run


def nominals(run: Run, name: str) -> dict[str, float]:
    """What the FMU says of its variables."""
    return {v.name: float(v.nominal or 1.0) for v in run.description(name).modelVariables}  # type: ignore[attr-defined]


def error(run: Run, name: str, tolerance: float) -> float:
    """The largest error at the end, in units of each component's size plus its nominal value."""
    nominal = nominals(run, name)
    last = run(name, tolerance)[-1]
    assert last["time"] == PROBLEMS[name]["stop"]
    return max(
        abs(float(last[key]) - value) / (abs(value) + nominal[key]) for key, value in PROBLEMS[name]["values"].items()
    )


@pytest.mark.parametrize("tolerance", TOLERANCES)
@pytest.mark.parametrize("name", sorted(PROBLEMS))
def test_the_published_solution_is_reached_within_the_tolerance(run: Run, name: str, tolerance: float) -> None:
    # the modulator passes on each error of a step through ten periods of its carrier
    assert error(run, name, tolerance) < (100 if name == "RingModulator" else 10) * tolerance


@pytest.mark.parametrize("name", sorted(PROBLEMS))
def test_the_error_falls_with_the_tolerance(run: Run, name: str) -> None:
    coarse, middle, fine = (error(run, name, tolerance) for tolerance in TOLERANCES)
    assert middle < coarse / 10
    assert fine < middle / 10


def test_robertson_keeps_the_amount_of_substance(run: Run) -> None:
    rows = run("Robertson", 1e-4, 50)
    assert rows["y1"] + rows["y2"] + rows["y3"] == pytest.approx(1.0, abs=1e-13)


def test_the_enzyme_of_hires_is_free_or_bound(run: Run) -> None:
    rows = run("Hires", 1e-4, 50)
    assert rows["y[7]"] + rows["y[8]"] == pytest.approx(0.0057, abs=1e-14)


def test_pollution_keeps_nitrogen_and_sulphur(run: Run) -> None:
    """NO2, NO, PAN, HNO3, NO3 have one atom of nitrogen, N2O5 two; SO2 and SO4 have one of sulphur."""
    rows = run("Pollution", 1e-4, 50)
    nitrogen = sum(rows[f"y[{k}]"] for k in (1, 2, 13, 15, 19)) + 2 * rows["y[20]"]
    assert nitrogen == pytest.approx(0.2, abs=1e-14)
    assert rows["y[17]"] + rows["y[18]"] == pytest.approx(0.007, abs=1e-14)


@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_the_scale_of_time_and_size_does_not_matter(run: Run, tolerance: float) -> None:
    """With its nominal scaled as the rate is, a problem in other units is solved by the same steps."""
    slow, fast = run("VanDerPol", tolerance, 40), run("VanDerPolScaled", tolerance, 40)
    assert slow["x"] == pytest.approx(fast["x"], abs=1e-9)
    assert slow["v"] * 1000 == pytest.approx(fast["v"], abs=1e-6)


def test_the_amplifier_keeps_only_the_voltages_of_its_capacitors_as_states() -> None:
    pytest.importorskip("rumoca")
    dae = compile_model(STIFF / "TransistorAmplifier.mo", "Stiff.TransistorAmplifier")
    assert [state.name for state in dae.states] == ["c1.v", "c2.v", "c3.v", "c4.v", "c5.v"]
    # the potentials of the two bases, which all other currents follow from
    assert [torn.name for torn in dae.torn] == ["y[2]", "y[5]"]


@pytest.mark.parametrize("tolerance", TOLERANCES)
@pytest.mark.parametrize("name", ["Hires", "Oregonator", "Pollution", "TransistorAmplifier", "VanDerPolScaled"])
def test_rows_between_the_steps_are_as_accurate(run: Run, name: str, tolerance: float) -> None:
    """400 rows, most of them from the dense output, against the same at a tolerance of 1e-11.

    Where the solution jumps, a row shows the error of the jump's instant.
    """
    nominal = nominals(run, name)
    exact, rows = run(name, 1e-11, 400), run(name, tolerance, 400)
    for key in PROBLEMS[name]["values"]:
        assert np.abs((rows[key] - exact[key]) / (np.abs(exact[key]) + nominal[key])).max() < 100 * tolerance


def test_e5_keeps_its_balance_over_thirteen_decades(run: Run) -> None:
    """When the reactant is used up y2 = y3 = y, and dy/dt = -M C y^2 leaves y = 1 / (M C t) in the end."""
    last = run("E5", 1e-8)[-1]
    assert last["y3"] == pytest.approx(last["y2"] - last["y4"], rel=1e-12)
    assert last["y2"] == pytest.approx(1 / (1e6 * 1.13e3 * 1e13), rel=2e-3)

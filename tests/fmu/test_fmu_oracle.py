"""Our reduction, choice of states, tearing, C and solver against CasADi's reduction with IDAS, and rumoca's solver."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from oracle import trajectories

TESTS = Path(__file__).parents[1]
SMALL = TESTS / "models" / "Small"
LIBRARY = TESTS.parent / "modelica" / "WiperDrive"

Simulate = Callable[..., Any]

rumoca = pytest.importorskip("rumoca")


@pytest.mark.parametrize(
    ("name", "stop", "inputs"),
    [
        ("PendulumXY", 3, {}),
        ("DoublePendulum", 3, {}),
        ("SliderCrank", 2, {"tau": 0.3}),
        ("GearedInertias", 5, {"tau": 1.0}),
        ("SeriesInductors", 0.5, {"u": 10.0}),
        ("ParallelCapacitors", 1, {"u": 5.0}),
        ("Atwood", 1, {}),
        ("FourBar", 1, {"tau": 0.05}),
        ("Cycloid", 2, {}),
        ("IndexTwo", 3, {}),
        ("LossyGear", 0.1, {"tau": -3.0}),
    ],
)
def test_a_small_model_moves_as_casadi_and_idas_say(
    simulate: Simulate, name: str, stop: float, inputs: dict[str, float]
) -> None:
    grid = np.linspace(0, stop, 41)
    expected = trajectories(SMALL / f"{name}.mo", f"Small.{name}", grid, inputs)
    result = simulate(name, stop, step=stop / 40, **inputs)
    compared = [column for column in result.dtype.names if column in expected]
    assert compared
    for column in compared:
        size = max(1.0, np.abs(expected[column]).max())
        assert result[column] == pytest.approx(expected[column], abs=1e-5 * size), column


@pytest.mark.slow
@pytest.mark.parametrize("name", ["LinkagePlant", pytest.param("RigPlant", marks=pytest.mark.slow)])
def test_a_plant_moves_as_casadi_and_idas_say(simulate: Simulate, name: str) -> None:
    # from rest at full voltage: the bridge conducts throughout, so that no relation changes its value
    grid = np.linspace(0, 3, 301)
    expected = trajectories(LIBRARY, f"WiperDrive.Systems.{name}", grid, {"duty": 1.0})
    result = simulate(f"WiperDrive.Systems.{name}", 3, step=0.01, duty=1.0)
    compared = {"phi_crank", "w_crank", "i_motor", "w_motor"} & set(expected)
    if name == "LinkagePlant":
        compared |= {"phi_ds", "phi_ps", "tau_ds"} & set(expected)
    assert {"phi_crank", "w_crank"} <= compared
    assert result["phi_crank"][-1] > 2 * np.pi, "less than a revolution tests too little"
    for column in sorted(compared):
        size = max(1.0, np.abs(expected[column]).max())
        assert result[column] == pytest.approx(expected[column], abs=2e-5 * size), column


RUMOCA: dict[str, tuple[float, dict[str, float]]] = {
    "MotorOnSpring": (1, {"u": 10.0}),
    "PendulumAngle": (3, {}),
    "SeriesInductors": (0.5, {"u": 10.0}),
    "ParallelCapacitors": (1, {"u": 5.0}),
    "GearedInertias": (5, {"tau": 1.0}),
    "SliderCrank": (2, {"tau": 0.3}),
    "DoublePendulum": (2, {}),
    "PendulumXY": (2, {}),
    "BouncingBall": (1.5, {}),
    "Rectifier": (0.2, {"u": 10.0}),
    "SampledPI": (2.05, {"w": 1.0}),
    "Tank": (12, {}),
    "Steps": (2.05, {}),
    "Rod": (2, {}),
    "Momentum": (5, {}),
    "SteadyStart": (1, {"u": 12.0}),
    "Coupled": (3, {}),
    "Lights": (5.01, {}),
    "Atwood": (1, {}),
    "Backlash": (2, {}),
    "Brake": (4, {"tau": 0.0}),
    "ChargeSharing": (0.5, {}),
    "Chopper": (0.0101, {}),
    "Chua": (8, {}),
    "Collisions": (12, {}),
    "Counter": (3, {}),
    "Cycloid": (3, {}),
    "Cyclotron": (3, {}),
    "FourBar": (2, {"tau": 0.05}),
    "GyratorMotor": (1, {"u": 12.0}),
    "HeatModes": (0.5, {}),
    "IndexThree": (2, {}),
    "IndexTwo": (3, {}),
    "Kepler": (7, {}),
    "Logistic": (8, {}),
    "LossyGear": (0.4, {"tau": 3.0}),
    "LotkaVolterra": (10, {}),
    "OperatingPoint": (1e-3, {"u": 12.0}),
    "QuarterCar": (1, {"road": 0.05}),
    "Resonance": (0.5, {}),
    "RestingBall": (3, {}),
    "RollingWheel": (1, {}),
    "Schmitt": (0.5, {}),
    "SendOnDelta": (6.95, {}),
    "StickSlip": (3, {}),
    "Thermostat": (5000, {}),
    "Transformer": (1, {"u": 10.0}),
    "TwoTanks": (3, {}),
}


# plain differential equations: nothing in them is new to the compiler, so they are left to the long run
PLAIN = {"Cyclotron", "GyratorMotor", "HeatModes", "Kepler", "Logistic", "LotkaVolterra", "QuarterCar", "Resonance"}
PLAIN |= {"RollingWheel", "Transformer"}


def test_every_small_model_is_compared_with_rumocas_solver() -> None:
    models = {file.stem for file in SMALL.glob("*.mo")} - {"package", "Parts"}
    assert len(models) >= 36
    assert set(RUMOCA) == models
    table = re.findall(r"^\| ([A-Z]\w+) \|", (SMALL.parent / "README.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert table == sorted(models), "tests/models/README.md has a row for each"


def by_rumoca(name: str, stop: float, step: float, inputs: dict[str, float]) -> dict[str, np.ndarray]:
    bound = ", ".join(f"{key}={value!r}" for key, value in inputs.items())
    text = f"""
        model Wrapper "Wrapper"
          Small.{name} x({bound}) "Model";
        end Wrapper;"""
    model = rumoca.Session(roots=[str(SMALL)]).loads(text, model="Wrapper", filename="Wrapper.mo")
    result = model.simulate(stop, dt=step, config=rumoca.SimConfig(solver="bdf", rtol=1e-9, atol=1e-9))
    columns = {key.removeprefix("x."): np.asarray(result[key], dtype=float) for key in result.names}
    return columns | {"time": np.asarray(result.time, dtype=float)}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in PLAIN)) for name in sorted(RUMOCA)]
)
def test_a_small_model_moves_as_rumocas_solver_says(simulate: Simulate, name: str) -> None:
    stop, inputs = RUMOCA[name]
    expected = by_rumoca(name, stop, stop / 37, inputs)
    result = simulate(name, stop, step=stop / 37, **inputs)
    for column in result.dtype.names[1:]:
        if (name, column) == ("Steps", "rounded_up"):
            continue  # rumoca 0.10 keeps ceil(0) until the next integer; the law is tested with the small models
        size = max(1.0, np.abs(expected[column]).max())
        at = np.interp(result["time"], expected["time"], expected[column])
        # fmpy reads the first row before the tick of a clock at t = 0
        assert result[column][1:].astype(float) == pytest.approx(at[1:], abs=1e-4 * size), column

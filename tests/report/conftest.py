"""A run that never was: smooth signals under the names of the wiper drive, and FMUs that are lists of parameters."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from cosim.engine import Component, Fmu, Result, System, Variable

STATES = ("IDLE", "Soft_start", "RUN", "turn_point_dec", "turn_point_acc", "Soft_stop")


@pytest.fixture
def result() -> Result:
    time = np.linspace(0, 10, 1001)
    phi = 2.9 * time
    columns = {
        "plant.i_motor": 2 + np.sin(phi) ** 2,
        "plant.park": (phi % (2 * np.pi) < 0.03).astype(np.int64),
        "plant.phi_crank": phi,
        "plant.tau_crank": 8 * np.sin(phi) ** 2,
        "plant.phi_ds": np.sin(phi),
        "plant.w_ds": 2.9 * np.cos(phi),
        "controller.duty": np.full(1001, 0.7),
        "controller.state": (1 + time.astype(np.int64) % 6),
        "controller.i_filtered": 2 + np.sin(phi - 0.2) ** 2,
        "controller.i_limit": np.full(1001, 2.1),
    }
    units = {
        "plant.i_motor": "A",
        "plant.phi_crank": "rad",
        "plant.tau_crank": "N.m",
        "plant.phi_ds": "rad",
        "plant.w_ds": "rad/s",
        "controller.duty": "1",
        "controller.i_filtered": "A",
        "controller.i_limit": "A",
    }
    statistics: dict[str, object] = {
        "wall_s": 0.5,
        "exchanges": 10001,
        "roles": {"plant": "continuous", "controller": "event"},
        "steps": {"plant": 10001, "controller": 10000},
        "events": {"controller": 10001},
        "solver": {
            "plant": {"steps": 12345, "rejected_steps": 6, "state_events": 7, "time_events": 0},
            "controller": {},
        },
    }
    return Result(time, columns, units, {"controller.state": STATES}, statistics)


def _fmu(name: str, *variables: Variable) -> Fmu:
    fake = SimpleNamespace(
        name=name,
        path=Path("somewhere", f"{name}.fmu"),
        fmi_version="3.0",
        sha256=name[0] * 64,
        generation_tool="cosim",
        variables={v.name: v for v in variables},
    )
    return cast(Fmu, fake)


@pytest.fixture
def system() -> System:
    plant = _fmu(
        "LinkagePlant",
        Variable("ext_load", "Real", "parameter", "fixed", "N.m", "external load [S] table 3.2", 3.0, 1, None),
        Variable("J_rotor", "Real", "parameter", "fixed", "kg.m2", "inertia [A] 70 W-class motor", 1e-4, 2, None),
        Variable("i_max", "Real", "parameter", "fixed", "A", "current limit", float("inf"), 3, None),
        Variable("i_motor", "Real", "output", "continuous", "A", None, None, 4, None),
    )
    controller = _fmu(
        "VoltageProfile", Variable("T_sample", "Real", "parameter", "fixed", "s", "hold [S] 3.5", 0.02, 1, None)
    )
    return System([Component("plant", plant, {"ext_load": 4.0}), Component("controller", controller)])

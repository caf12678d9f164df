"""Data from the tests' own minimal-coordinate model, which is not the one that is fitted."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from measurement.workbooks import Columns, write
from reference.plant import LinkageLoad, Motor, Plant, WormGear
from reference.simulation import simulate

Array = NDArray[np.float64]

TRUE = {"d_joint": 0.95, "ext_load": 3.6, "gear.eta_wg": 0.70, "J_rotor": 1.3e-4, "motor.R": 1.91}
"""What the data are made with; the model's own values are 0.859, 3, 0.74, 1e-4, 1.91."""
SAMPLE = 0.002
_LINE = (0.173, 0.58)
"""Current over torque, as in a workbook's Tp."""


@cache
def run(supply: float, resistance: float = TRUE["motor.R"], length: float = 7.5) -> dict[str, Array]:
    """Full duty from rest at a constant voltage [V]."""
    plant = Plant(
        LinkageLoad(damping=TRUE["d_joint"], ext_load=TRUE["ext_load"]),
        Motor(R=resistance, J_rotor=TRUE["J_rotor"]),
        WormGear(eta_wg=TRUE["gear.eta_wg"]),
    )
    time = SAMPLE * np.arange(round(length / SAMPLE) + 1)
    return simulate(plant, 1.0, time, v_supply=supply, rtol=1e-8, atol=1e-10, method="LSODA", max_step=5e-3)


def workbook(path: Path, supply: float, resistance: float = TRUE["motor.R"], seed: int = 0) -> Path:
    """A workbook of the supplier: the motor stands for 0.8 s, then starts; noisy and quantised."""
    rng = np.random.default_rng(seed)
    rest = 400
    current = np.concatenate((np.zeros(rest), run(supply, resistance)["i_motor"]))
    count = len(current)
    each = np.round(current + 0.04 * rng.standard_normal(count), 2)
    average = np.round(np.convolve(np.concatenate((np.zeros(54), each)), np.full(55, 1 / 55), "valid"), 5)
    voltage = np.round(supply + 0.02 * rng.standard_normal(count), 2)
    index = np.arange(count, dtype=float)
    return write(path, Columns(voltage.tolist(), index.tolist(), each.tolist(), average.tolist(), Tp=_LINE))


def with_torque(path: Path, supply: float, seed: int = 0) -> Path:
    """A CSV file with current, voltage and a torque that a sensor on the gear's shaft measures."""
    rng = np.random.default_rng(seed)
    made = run(supply)
    rows = zip(
        made["time"],
        made["i_motor"] + 0.04 * rng.standard_normal(len(made["time"])),
        supply + 0.02 * rng.standard_normal(len(made["time"])),
        made["tau_crank"] + 0.1 * rng.standard_normal(len(made["time"])),
        strict=True,
    )
    lines = [f"{t:.3f},{i:.2f},{v:.2f},{torque:.2f}" for t, i, v, torque in rows]
    path.write_text("time [s],current [A],voltage [V],torque [N.m]\n" + "\n".join(lines) + "\n", encoding="utf-8")
    return path

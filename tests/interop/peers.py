"""Runs a system in another tool, through the workers of benchmarks/_peers, each a process of its own."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cosim.engine import Channel, Component, Connection, Fmu, System, simulate

WORKERS = Path(__file__).parents[2] / "benchmarks" / "_peers"
PEERS = {"ecos": "ecospy", "libcosim": "libcosimpy", "fmutool_container": "fmu_manipulation_toolbox"}
"""Each worker's script, and the module that it needs."""

Rows = dict[str, NDArray[np.float64]]


@dataclass(frozen=True)
class Case:
    """FMUs by name, start values and parameters, connections as in ``Connection``, and what is recorded.

    Macro steps of ``step`` [s] until ``stop`` [s], a row every ``every`` of them.
    """

    fmus: dict[str, Path]
    values: dict[str, dict[str, float]]
    connections: tuple[tuple[str, str, str, str], ...]
    outputs: tuple[tuple[str, str], ...]
    step: float
    stop: float
    every: int

    @property
    def names(self) -> list[str]:
        return [".".join(output) for output in self.outputs]


def run_peer(peer: str, case: Case, folder: Path) -> Rows:
    """Return the rows of a peer: of some the first is that of the start, of others that after ``every`` steps."""
    job = {
        "parts": [{"name": n, "path": str(path), "parameters": case.values[n]} for n, path in case.fmus.items()],
        "connections": case.connections,
        "outputs": case.outputs,
        "step": case.step,
        "stop": case.stop,
        "every": case.every,
        "folder": str(folder),
        "variant": "simulate_fmu",
    }
    worker = [sys.executable, str(WORKERS / f"{peer}.py")]
    done = subprocess.run(worker, input=json.dumps(job), capture_output=True, text=True, timeout=300, check=False)
    lines = done.stdout.splitlines()
    assert len(lines) == 2, f"{peer} has ended with code {done.returncode}:\n{done.stderr[-2000:]}"
    answer = json.loads(lines[1])
    assert "error" not in answer, answer
    return {name: np.array(column) for name, column in answer["rows"].items()}


def run_ours(case: Case, *, jacobi: bool) -> Rows:
    """Return our rows, from the start on.

    Peers do not tell FMUs when the simulation ends, and a solver steps otherwise towards an end that it knows: so ours
    goes on for a second longer.
    """
    components, channels = [], []
    for name, path in case.fmus.items():
        fmu = Fmu.read(path)
        inputs = {key: value for key, value in case.values[name].items() if fmu.variables[key].causality == "input"}
        parameters = {key: value for key, value in case.values[name].items() if key not in inputs}
        components.append(Component(name, fmu, dict(parameters)))
        channels += [Channel((name, key), [0.0], [value]) for key, value in inputs.items()]
    connections = [Connection((a, out), (b, into)) for a, out, b, into in case.connections]
    result = simulate(
        System(components, connections, channels),
        stop=case.stop + 1.0,
        output_interval=case.step,
        tolerance=1e-6,
        algorithm="jacobi" if jacobi else "gauss-seidel",
        step=case.step if jacobi else None,
    )
    shown = slice(0, round(case.stop / case.step) + 1, case.every)
    return {"time": result.time[shown]} | {name: result.columns[name][shown].astype(float) for name in case.names}


def agree(ours: Rows, theirs: Rows, case: Case, within: float) -> None:
    """Assert that all numbers at the same times do; a peer's first row may be that of its first steps."""
    count = len(theirs["time"])
    assert count in (len(ours["time"]), len(ours["time"]) - 1)
    np.testing.assert_allclose(theirs["time"], ours["time"][-count:], rtol=0.0, atol=1e-9)
    for name in case.names:
        np.testing.assert_allclose(theirs[name], ours[name][-count:], rtol=within, atol=within, err_msg=name)

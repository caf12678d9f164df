"""The command line with an engine and a catalogue that only pretend, so that these tests build and simulate nothing."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from cosim import engine
from cosim.cli import _run
from cosim.cli._app import app
from cosim.engine import Fmu, System, Variable
from cosim.errors import InputError, ModelError, ModelWarning
from cosim.fmu import toolchain
from cosim.fmu.versions import FmiChoice, file_name, versions_of

Cosim = Callable[..., Result]


def _variable(name: str, causality: str, unit: str | None, start: float | None = None) -> Variable:
    return Variable(name, "Real", causality, "continuous", unit, f"the {name} [A] test", start, 0, None)


PLANT = SimpleNamespace(
    name="LinkagePlant",
    path=Path("LinkagePlant.fmu"),
    fmi_version="3.0",
    sha256="0" * 64,
    generation_tool="cosim",
    variables={
        v.name: v
        for v in (
            _variable("duty", "input", "1", 0.0),
            _variable("i_motor", "output", "A"),
            _variable("ext_load", "parameter", "N.m", 3.0),
            _variable("i_max", "parameter", "A", float("inf")),
        )
    },
    capabilities={"canBeInstantiatedOnlyOncePerProcess": False, "platforms": ("x86_64-linux",)},
)


@pytest.fixture
def cosim(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Cosim:
    """Run a command in an empty folder; gives exit code, stdout and stderr."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.setattr(Fmu, "read", staticmethod(lambda path: PLANT))
    runner = CliRunner()
    return lambda *arguments: runner.invoke(app, [str(argument) for argument in arguments])


@pytest.fixture(autouse=True)
def built(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Put a pretended compiler in place; gives what it was asked for."""
    asked: list[str] = []
    compiled: list[str] = []
    catalogue: Any = ModuleType("cosim.fmu.catalogue")
    catalogue.names = lambda: {"linkage": SimpleNamespace(fmu_name="LinkagePlant", kind="system")}

    def ensure(name: str) -> Path:
        if name not in ("linkage", "LinkagePlant"):
            raise InputError(f"no built-in plant or controller '{name}'")
        asked.append(name)
        return Path(f"{name}.fmu")

    def build(names: list[str] | None, out: Path | None, fmi: FmiChoice, platforms: str, **_: object) -> list[Path]:
        if names and "linkgae" in names:
            raise InputError("no built-in plant or controller 'linkgae'")
        return [
            (out or Path("fmus")) / file_name(name, version)
            for name in names or ["linkage", "rig"]
            for version in versions_of(fmi)
        ]

    def pack_all(dae: str, out: Path, *, fmi: FmiChoice, **_: object) -> list[Path]:
        return [out / file_name(dae.rpartition(".")[2], version) for version in versions_of(fmi)]

    def compile_model(file: Path, model: str, *, strict_units: bool = False) -> str:
        compiled.append(model)
        if model == "P.Wrong":
            raise ModelError("an equation is missing", file=file, line=7)
        if model == "P.Doubtful":
            warnings.warn("x.mo:3:3: v = i: v is in V, but i is in A", ModelWarning, stacklevel=2)
        return f"dae of {model}"

    catalogue.ensure, catalogue.build = ensure, build
    fmu: Any = ModuleType("cosim.fmu")
    fmu.catalogue = catalogue
    fmu.compile_model = compile_model
    fmu.compiled = compiled
    fmu.pack_all = pack_all
    dae: Any = ModuleType("cosim.dae")
    dae.explain = lambda compiled: f"explained: {compiled}"
    for name, module in {
        "cosim.fmu": fmu,
        "cosim.fmu.toolchain": toolchain,
        "cosim.fmu.catalogue": catalogue,
        "cosim.dae": dae,
    }.items():
        monkeypatch.setitem(sys.modules, name, module)
    return asked


@pytest.fixture(autouse=True)
def simulated(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, object]]:
    """Put a pretended engine in place; gives what it was asked for."""
    asked: list[dict[str, object]] = []

    def simulate(system: System, **options: object) -> engine.Result:
        asked.append(options | {"parameters": system.components[0].parameters})
        return engine.Result(
            np.array([0.0, 0.5, 1.0]),
            {"plant.i_motor": np.array([0.0, 1.0, 2.0])},
            {"plant.i_motor": "A"},
            statistics={"wall_s": 0.25, "exchanges": 3, "solver": {"plant": {"steps": 40}}},
        )

    monkeypatch.setattr(_run, "simulate", simulate)
    return asked


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    path = tmp_path / "x.csv"
    path.write_text("# title: X\n# system: linkage\n# controller: none\n# stop: 1 s\ntime [s],duty [1]\n0,1\n")
    return path

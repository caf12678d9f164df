"""An importer that goes through the states of an FMI 3.0 Co-Simulation FMU by hand, through fmpy's binding."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any, Self

import fmpy
import numpy as np
from fmpy.fmi3 import FMU3Slave
from fmpy.model_description import ModelVariable

SUFFIX = {"Float64": "Float64", "Int32": "Int32", "Boolean": "Boolean", "Enumeration": "Int64", "UInt64": "UInt64"}


class Importer:
    """One instance of an FMU; a context manager."""

    def __init__(self, path: Path) -> None:
        self.description = fmpy.read_model_description(str(path))
        self.variables: dict[str, ModelVariable] = {v.name: v for v in self.description.modelVariables}
        self._folder = fmpy.extract(str(path))
        self.fmu: Any = FMU3Slave(
            guid=self.description.guid,
            unzipDirectory=self._folder,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="instance",
        )
        self.said: list[str] = []
        """What the FMU has logged."""

        self.instantiate()
        self.time = 0.0

    def say(self, _environment: object, _status: int, _category: bytes, message: bytes) -> None:
        self.said.append(message.decode())

    def instantiate(self) -> None:
        self.fmu.instantiate(loggingOn=True, logMessage=self.say)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.fmu.freeInstance()
        shutil.rmtree(self._folder, ignore_errors=True)

    def start(self) -> None:
        """Go to Step Mode."""
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def step(self, h: float) -> None:
        self.fmu.doStep(self.time, h)
        self.time += h

    def get(self, name: str) -> float:
        variable = self.variables[name]
        return float(getattr(self.fmu, f"get{SUFFIX[variable.type]}")([variable.valueReference])[0])

    def set(self, name: str, value: float) -> None:
        variable = self.variables[name]
        whole = variable.type != "Float64"
        getattr(self.fmu, f"set{SUFFIX[variable.type]}")([variable.valueReference], [int(value) if whole else value])

    def directional(self, unknowns: list[str], knowns: list[str]) -> Any:  # noqa: ANN401 - an array
        """The matrix of derivatives, column by column."""
        rows, columns = self.references(unknowns), self.references(knowns)
        seeds = np.eye(len(columns))
        return np.array([self.fmu.getDirectionalDerivative(rows, columns, list(seed)) for seed in seeds]).T

    def adjoint(self, unknowns: list[str], knowns: list[str]) -> Any:  # noqa: ANN401 - an array
        """The matrix of derivatives, row by row."""
        rows, columns = self.references(unknowns), self.references(knowns)
        seeds = np.eye(len(rows))
        return np.array([self.fmu.getAdjointDerivative(rows, columns, list(s), len(columns)) for s in seeds])

    def references(self, names: list[str]) -> list[int]:
        return [self.variables[name].valueReference for name in names]

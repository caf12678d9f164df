"""Intermediate update: the importer is called back at the solver's steps, may read there, and may end the step."""

from __future__ import annotations

from collections.abc import Callable
from ctypes import addressof, c_bool, c_double
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi3 import fmi3IntermediateUpdateCallback
from importer import Importer

pytest.importorskip("rumoca")

Build = Callable[[str], Path]


class Watcher(Importer):
    """Reads variables whenever it is called back."""

    def __init__(self, path: Path, names: list[str], stop_after: float = np.inf, tries: tuple[str, ...] = ()) -> None:
        self.seen: list[list[float]] = []
        self.refused: list[str] = []
        self.names, self.stop_after, self.tries = names, stop_after, tries
        super().__init__(path)

    def instantiate(self) -> None:
        self.callback = fmi3IntermediateUpdateCallback(self.update)
        self.fmu.instantiate(
            loggingOn=True, logMessage=self.say, earlyReturnAllowed=True, intermediateUpdate=self.callback
        )

    def update(
        self,
        _: object,
        time: float,
        setting: bool,
        getting: bool,
        done: bool,
        early: bool,
        wanted: Any,  # noqa: ANN401 - a pointer
        at: Any,  # noqa: ANN401 - a pointer
    ) -> None:
        assert (setting, getting, done, early) == (False, True, True, True)
        self.seen.append([time, *(self.get(name) for name in self.names)])
        for call in self.tries:
            try:
                {
                    "set": lambda: self.set("u", 1.0),
                    "step": lambda: self.fmu.doStep(time, 0.1),
                    "reset": self.fmu.reset,
                    "save": self.fmu.getFMUState,
                }[call]()
            except FMICallException:
                self.refused.append(call)
        if time > self.stop_after:
            c_bool.from_address(_address(wanted)).value = True
            c_double.from_address(_address(at)).value = time


def _address(pointer: Any) -> int:  # noqa: ANN401
    return addressof(pointer.contents)


def run(importer: Importer) -> list[float]:
    importer.fmu.enterInitializationMode(tolerance=1e-6)
    importer.set("u", 12.0)
    importer.fmu.exitInitializationMode()
    for k in range(4):
        importer.fmu.doStep(0.25 * k, 0.25)
    return [importer.get(name) for name in ("time", "phi", "i")]


def test_what_is_read_at_the_solvers_steps_is_the_solution_there(build: Build) -> None:
    path = build("MotorOnSpring")
    with Importer(path) as plain, Watcher(path, ["time", "phi", "i"]) as watcher:
        assert run(watcher) == run(plain)
        seen = np.array(watcher.seen)
        steps = plain.get("solver.steps")
    assert len(seen) <= steps
    assert len(seen) > 10
    assert (np.diff(seen[:, 0]) > 0).all()
    assert (seen[:, 0] == seen[:, 1]).all()
    with Importer(path) as exact:
        exact.fmu.enterInitializationMode(tolerance=1e-11)
        exact.set("u", 12.0)
        exact.fmu.exitInitializationMode()
        time = 0.0
        for row in seen:
            exact.fmu.doStep(time, row[0] - time)
            time = row[0]
            assert row[2:] == pytest.approx([exact.get("phi"), exact.get("i")], rel=1e-4, abs=1e-5)


def test_the_importer_may_end_the_step_there(build: Build) -> None:
    with Watcher(build("MotorOnSpring"), [], stop_after=0.03) as watcher:
        watcher.start()
        _, _, early, last = watcher.fmu.doStep(0.0, 0.25)
        assert early
        assert last == watcher.seen[-1][0] == watcher.get("time")
        assert 0.03 < last < 0.25
        watcher.stop_after = np.inf
        _, _, early, last = watcher.fmu.doStep(last, 0.25 - last)
        assert (early, last) == (False, 0.25)


def test_what_the_callback_must_not_do_is_refused_and_harmless(build: Build) -> None:
    path = build("MotorOnSpring")
    with Importer(path) as plain, Watcher(path, [], tries=("set", "step", "reset", "save")) as watcher:
        assert run(watcher) == run(plain)
        assert watcher.refused == ["set", "step", "reset", "save"] * len(watcher.seen)
        assert "is not allowed in the callback of an intermediate update" in watcher.said[-1]

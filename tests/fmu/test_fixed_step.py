"""FMUs with a fixed step: the same number of evaluations in each step, bounded also with events, and no allocation."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from importer import Importer

from cosim.cli._builtin import step_of
from cosim.errors import InputError
from cosim.fmu import export
from cosim.fmu.toolchain import compiler, fmi_headers

pytest.importorskip("rumoca")

SMALL = Path(__file__).parents[1] / "models" / "Small"
LOCATED = 3
"""Events that are located within one step."""


def exported(name: str, folder: Path, step: float) -> Path:
    return export(SMALL / f"{name}.mo", f"Small.{name}", folder / f"{step}", fixed_step=step)


def counts(importer: Importer, step: float, number: int) -> tuple[list[float], list[float]]:
    """Evaluations and solver steps that each communication step takes."""
    found: list[list[float]] = [[], []]
    before = [importer.get(name) for name in ("solver.rhs_evaluations", "solver.steps")]
    for _ in range(number):
        importer.step(step)
        after = [importer.get(name) for name in ("solver.rhs_evaluations", "solver.steps")]
        for kind in range(2):
            found[kind].append(after[kind] - before[kind])
        before = after
    return found[0], found[1]


def test_each_step_costs_the_same(tmp_path: Path) -> None:
    path = exported("MotorOnSpring", tmp_path, 1e-3)
    assert validate_fmu(str(path)) == []
    read = fmpy.read_model_description(str(path))
    assert read.defaultExperiment.stepSize == "0.001"
    assert read.coSimulation.fixedInternalStepSize == "0.001"
    with Importer(path) as importer:
        importer.set("u", 12.0)
        importer.start()
        evaluations, steps = counts(importer, 1e-3, 200)
        assert set(steps) == {1}
        assert len(set(evaluations)) == 1
        # a longer communication step takes several; one that is no multiple of the step ends with a shorter one
        assert counts(importer, 5e-3, 1)[1] == [5]
        assert counts(importer, 2.5e-3, 1)[1] == [3]


def test_the_error_falls_with_the_order_of_the_method(tmp_path: Path) -> None:
    """Of prey and predators one quantity stays constant; the method, of order five, lets it drift less and less."""
    drifts = []
    for step in (4e-1, 2e-1):
        with Importer(exported("LotkaVolterra", tmp_path, step)) as importer:
            importer.start()
            before = importer.get("H")
            for _ in range(round(10.0 / step)):
                importer.step(step)
            drifts.append(abs(importer.get("H") - before))
    assert drifts[0] / drifts[1] > 2**4


def test_events_are_located_and_bounded(tmp_path: Path) -> None:
    step = 5e-3
    with Importer(exported("BouncingBall", tmp_path, step)) as importer:
        importer.start()
        h_0, e = importer.get("h"), importer.get("e")
        fall = np.sqrt(2 * h_0 / 9.81)
        _, steps = counts(importer, step, int(fall / step) + 10)
        first = importer.get("last_bounce")
        # the first contact is where it is, not where a step ends
        assert first == pytest.approx(fall, abs=1e-6)
        # what is left of the step is taken from the event at the contact on, and from the one when it ends
        assert max(steps) == 3
        # bounces that follow each other ever faster do not make a step longer than a few of the usual ones
        _, steps = counts(importer, step, round(2 * fall / (1 - e) / step))
        assert max(steps) <= LOCATED + 1
        assert importer.get("bounces") > 10


@pytest.mark.skipif(sys.platform != "linux", reason="takes the place of glibc's functions")
@pytest.mark.parametrize("fixed", [1e-3, None])
def test_no_step_allocates_memory(tmp_path: Path, fixed: float | None) -> None:
    path = export(SMALL / "Rectifier.mo", "Small.Rectifier", tmp_path, fixed_step=fixed)
    read = fmpy.read_model_description(str(path))
    inputs = [v.valueReference for v in read.modelVariables if v.causality == "input" and v.type == "Float64"]
    (library,) = Path(fmpy.extract(str(path), str(tmp_path / "unzipped"))).glob("binaries/*/*.so")
    program = tmp_path / "count"
    source = Path(__file__).with_name("count_allocations.c")
    command = [*compiler(), "-I", str(fmi_headers()), str(source), "-o", str(program), "-ldl"]
    subprocess.run(command, check=True)
    arguments = [str(program), str(library), read.instantiationToken, str(inputs[0] if inputs else -1), "1e-3", "2000"]
    done = subprocess.run(arguments, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "0\n")


def test_the_length_of_a_step_is_a_time() -> None:
    assert step_of("1ms") == step_of("0.001 s") == 1e-3
    assert step_of(None) is None
    for text, said in (("1 kg", "write a time"), ("0 s", "at least 1 us"), ("-1 ms", "at least 1 us")):
        with pytest.raises(InputError, match=said):
            step_of(text)

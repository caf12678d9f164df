"""Random sequences of right and wrong FMI calls, under sanitizers and valgrind; fuzz/fuzz.h says what is judged."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Literal

import pytest
from runtime_harness import HEADERS, HERE, RUNTIME, TOKEN, runtime_sources, write_sizes

pytestmark = pytest.mark.skipif(not shutil.which("gcc") or sys.platform != "linux", reason="needs gcc")
SANITIZERS = ("-fsanitize=address,undefined", "-fno-sanitize-recover=undefined")
DRIVER = HERE / "fuzz"
SAMPLES = sorted(path.stem for path in (HERE / "models").glob("*.c"))
QUICK = (("sampler", 2), ("faults", 3))
ALL = [
    pytest.param(name, fmi, marks=[] if (name, fmi) in QUICK else pytest.mark.slow)
    for name in SAMPLES
    for fmi in (2, 3)
]


def driver(model: Path, folder: Path, fmi: int, *flags: str) -> Path:
    """The driver with the runtime and a model, whose sizes are in the folder."""
    program = folder / "fuzz"
    own = [DRIVER / name for name in ("fuzz.c", "fuzz_calls.c", f"fuzz_fmi{fmi}.c")]
    wrapped = "-Wl,--wrap=malloc,--wrap=calloc,--wrap=free"
    includes = ["-isystem", HEADERS, "-I", RUNTIME, "-I", folder, "-I", HERE / "models", "-I", DRIVER]
    strict = ["-std=c11", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off", "-O1", "-g"]
    command = ["gcc", *strict, *flags, wrapped, *includes, model, *runtime_sources(fmi), *own, "-lm", "-o", program]
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return program


def play(command: list[str | Path], seed: int, calls: int, judge: Literal["strict", "forgiving", "faulty"]) -> None:
    """A sequence of calls, of which many are wrong, and many are not."""
    done = subprocess.run([*command, str(seed), str(calls), judge], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-4000:]
    made, wrong = (int(number) for number in re.findall(r"\d+", done.stdout))
    assert 0.1 * made < wrong < 0.9 * made


@pytest.mark.parametrize(("name", "fmi"), ALL)
def test_wrong_calls_are_refused_and_leave_no_trace(name: str, fmi: int, tmp_path: Path) -> None:
    model = HERE / "models" / f"{name}.c"
    write_sizes(model, tmp_path)
    program = driver(model, tmp_path, fmi, *SANITIZERS)
    for seed in range(3):
        play([program], seed, 5000, "faulty" if name == "faults" else "strict")


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("name", ["Systems.RigPlant", "Controllers.VoltageProfile"])
def test_a_generated_model_stands_the_same(name: str, fmi: int, tmp_path: Path) -> None:
    pytest.importorskip("rumoca")
    from cosim.fmu.codegen import generate
    from cosim.fmu.exporter import compile_model
    from cosim.fmu.layout import lay_out

    dae = compile_model(HERE.parents[1] / "modelica" / "WiperDrive", f"WiperDrive.{name}")
    for file, text in generate(dae, lay_out(dae), TOKEN).items():
        (tmp_path / file).write_text(text)
    # sanitizers make the optimiser take minutes over a long generated function
    program = driver(tmp_path / "model.c", tmp_path, fmi, *SANITIZERS, "-Wno-unused", "-O0")
    for seed in range(2):
        play([program], seed, 2000, "forgiving")


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("valgrind"), reason="needs valgrind")
@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("name", ["sampler", "four_bar", "faults"])
def test_valgrind_finds_nothing(name: str, fmi: int, tmp_path: Path) -> None:
    model = HERE / "models" / f"{name}.c"
    write_sizes(model, tmp_path)
    program = driver(model, tmp_path, fmi)
    # uninitialised values are what the sanitizers do not see
    valgrind: list[str | Path] = ["valgrind", "--quiet", "--error-exitcode=9", program]
    play(valgrind, 1, 1500, "faulty" if name == "faults" else "strict")

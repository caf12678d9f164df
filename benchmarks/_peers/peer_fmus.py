"""The FMUs that the peers are compared on, compiled from C with the shell of the test FMUs."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy

from cosim.fmu.toolchain import compiler

HERE = Path(__file__).parent
SHELL = HERE.parents[1] / "tests" / "fmus"
sys.path.insert(0, str(SHELL))

from fmu_builder import Described, Model, description  # noqa: E402

SAMPLER = Model(
    "sampler",
    (
        Described("u", 1, "input", start="0", unit="1"),
        Described("T_compute", 3, "parameter", "fixed", start="0.02"),
        Described("K", 4, "parameter", "fixed", start="1"),
        Described("y", 5, "output", "discrete", depends=("u",)),
        Described("t_sample", 6, "output", "discrete"),
    ),
    has_event_mode=True,
)
"""The sampler of the tests with real variables only: some peers have no others."""
INTEGRATOR = Model(
    "integrator",
    (
        Described("u", 1, "input", start="0", unit="1"),
        Described("x0", 2, "parameter", "fixed", start="0"),
        Described("x", 4, "output", unit="1"),
        Described("steps", 7, "output", "discrete"),
    ),
)
"""The integrator of the tests; ``steps`` counts its doStep calls."""
MOTOR = Model(
    "motor",
    (
        Described("u", 1, "input", start="0", unit="V"),
        Described("tau", 2, "parameter", "fixed", start="0.02", unit="N.m"),
        Described("w", 3, "output", unit="rad/s"),
        Described("i", 4, "output", unit="A"),
    ),
)
REGULATOR = Model(
    "regulator",
    (
        Described("w", 1, "input", start="0", unit="rad/s"),
        Described("Kp", 2, "parameter", "fixed", start="0.5"),
        Described("Ki", 3, "parameter", "fixed", start="5"),
        Described("u", 4, "output", unit="V"),
    ),
)


def build(model: Model, fmi: int, folder: Path) -> Path:
    """Compile and pack a model for FMI 2 or 3; return the path of the FMU."""
    name = model.source
    source = next(path for path in (HERE / f"{name}.c", SHELL / f"{name}.c") if path.exists())
    library = folder / f"{name}{fmi}{fmpy.sharedLibraryExtension}"
    headers = Path(fmpy.__file__).parent / "c-code"
    flags = ["-shared", "-fPIC", "-O2", "-std=c11", "-ffp-contract=off", "-w", f"-DFMI={fmi}"]
    sources = [str(source), str(SHELL / "stubs.c")]
    subprocess.run(
        [*compiler(), *flags, f"-I{headers}", f"-I{SHELL}", *sources, "-lm", "-o", str(library)],
        check=True,
    )
    platform = fmpy.platform if fmi == 2 else fmpy.platform_tuple
    path = folder / f"{name}{fmi}.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", description(model, fmi))
        archive.write(library, f"binaries/{platform}/{name}{fmpy.sharedLibraryExtension}")
    return path

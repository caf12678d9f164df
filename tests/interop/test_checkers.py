"""What other tools' checks say of our FMUs: nothing."""

from __future__ import annotations

import subprocess
import sys

import pytest
from fmpy.validation import validate_fmu

from cosim.fmu import catalogue
from cosim.fmu.versions import FmiVersion

from .conftest import Need

FMUS: list[tuple[str, FmiVersion]] = [(name, "3.0") for name in catalogue.names()]
FMUS += [(name, "2.0") for name in ("linkage", "rig", "voltage_profile", "speed_control")]


@pytest.mark.parametrize(("name", "fmi"), FMUS)
def test_nothing_is_found(need: Need, name: str, fmi: FmiVersion) -> None:
    need("fmu_manipulation_toolbox")
    path = catalogue.ensure(name, fmi)
    assert validate_fmu(str(path)) == []
    code = "import sys; from fmu_manipulation_toolbox.cli.fmutool import fmutool; sys.exit(fmutool())"
    done = subprocess.run(
        [sys.executable, "-c", code, "-input", str(path), "-check"],  # it reads the arguments of the process
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    said = [line for line in (done.stdout + done.stderr).splitlines() if line.strip()]
    assert any(f"compliant with FMI-{fmi}" in line for line in said), said
    assert not [line for line in said if not line.startswith("INFO") and "Modified FMU is not saved" not in line]

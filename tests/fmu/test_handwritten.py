"""The FMU in fmus/ that is written by hand: valid, complete, and strict about its steps."""

from __future__ import annotations

import subprocess
from pathlib import Path

import fmpy
import pytest
from fmpy.validation import validate_fmu

from cosim.engine import Channel, Component, Fmu, PartialResultError, System, simulate
from cosim.errors import BuildError
from cosim.fmu import catalogue
from cosim.fmu.handwritten import pack_folder, sources_of
from cosim.fmu.versions import FmiVersion

FOLDER = Path(__file__).parents[2] / "fmus" / "SpeedController"
versions: pytest.MarkDecorator = pytest.mark.parametrize("fmi", ["2.0", "3.0"])


@versions
def test_it_is_valid_and_integrates_its_error(fmi: FmiVersion) -> None:
    """At standstill the error is w_ref: duty_k = K_p w_ref + K_i w_ref k T until it reaches 1 and stays there."""
    path = catalogue.ensure("speed_control", fmi)
    assert validate_fmu(str(path)) == []
    with Fmu.read(path) as fmu:
        system = System([Component("c", fmu, {"w_ref": 1.0})], channels=[Channel(("c", "w_crank"), [0.0], [0.0])])
        result = simulate(system, stop=2.0, output_interval=0.01, tolerance=1e-6)
    exact = [min(0.2 + 0.6 * 0.01 * k, 1.0) for k in range(201)]
    assert result.columns["c.duty"] == pytest.approx(exact, abs=1e-12)


@versions
def test_other_steps_than_its_own_are_refused_with_its_words(fmi: FmiVersion) -> None:
    with Fmu.read(catalogue.ensure("speed_control", fmi)) as fmu:
        fmu.fixed_step = 0.02  # as if it had said something else
        system = System([Component("c", fmu)], channels=[Channel(("c", "w_crank"), [0.0], [0.0])])
        with pytest.raises(PartialResultError, match=r"takes steps of 0.01 s only, not of 0.02 s"):
            simulate(system, stop=1.0, output_interval=0.01, tolerance=1e-6)


@versions
def test_its_c_has_no_warnings(fmi: FmiVersion, tmp_path: Path) -> None:
    headers = Path(fmpy.__file__).parent / "c-code"
    flags = ["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only", "-isystem", str(headers)]
    subprocess.run(["cc", *flags, *map(str, sources_of(FOLDER, fmi))], check=True, cwd=tmp_path)


def test_a_folder_without_a_description_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BuildError, match=r"has no modelDescription.fmi2.xml, so there is no FMU for FMI 2.0"):
        pack_folder(tmp_path, tmp_path, fmi="2.0", build_hash=None, platforms="host")

"""Reading FMUs, and what is left behind: nothing."""

from __future__ import annotations

import gc
import hashlib
import re
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from fmpy.validation import validate_fmu
from test_engine_errors import repack, replacing

from cosim.engine import Component, Connection, Fmu, Role, System, Variable, role_of, simulate
from cosim.errors import FmuWarning

Get = Callable[..., Fmu]


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("model", ["sampler", "integrator", "faulty", "mirror", "label", "ball", "relay"])
def test_the_test_fmus_are_valid(fmu_path: Callable[[str, int], Path], model: str, version: int) -> None:
    assert validate_fmu(str(fmu_path(model, version))) == []


@pytest.mark.parametrize("version", [2, 3])
def test_description(fmu: Get, fmu_path: Callable[[str, int], Path], version: int) -> None:
    sampler = fmu("sampler", version)
    assert sampler.name == "sampler"
    assert sampler.fmi_version == f"{version}.0"
    assert sampler.generation_tool == "cosim tests"
    assert sampler.has_event_mode == (version == 3)
    assert sampler.path == fmu_path("sampler", version)
    assert sampler.sha256 == hashlib.sha256(sampler.path.read_bytes()).hexdigest()
    assert sampler.capabilities["canHandleVariableCommunicationStepSize"] is True
    in_time, at_start = sampler.dependencies, sampler.initial_dependencies
    assert in_time == at_start
    assert in_time["y"] == {"u", "enable"}
    assert sampler.variables["u"] == Variable("u", "Real", "input", "continuous", "m", None, 0.0, 1, None)
    assert sampler.variables["enable"] == Variable("enable", "Boolean", "input", "discrete", None, None, True, 2, None)
    assert sampler.variables["count"].type == "Integer"
    assert sampler.variables["side"].literals == ("left", "middle", "right")


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize(("claim", "provided"), [('="true"', True), ('="false"', False), ("  = '1'", True)])
def test_directional_derivatives_have_another_name_in_each_version(
    fmu_path: Callable[[str, int], Path], tmp_path: Path, version: int, claim: str, provided: bool
) -> None:
    attribute = f"providesDirectionalDerivative{'s' * (version - 2)}"
    edit = replacing("<CoSimulation ", f"<CoSimulation {attribute}{claim} ")
    with Fmu.read(repack(fmu_path("integrator", version), tmp_path / "x.fmu", edit)) as claiming:
        assert claiming.capabilities["providesDirectionalDerivative"] is provided


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize(
    ("attributes", "bounds"),
    [
        ('min="-1" max="2.5"', (-1.0, 2.5)),
        ('max="2.5"', (None, 2.5)),
        ('min="-INF" max="INF"', (None, None)),
        ('min="low"', (None, None)),
    ],
)
def test_declared_ranges(
    fmu_path: Callable[[str, int], Path],
    tmp_path: Path,
    version: int,
    attributes: str,
    bounds: tuple[float | None, float | None],
) -> None:
    edit = replacing('unit="m"', f'unit="m" {attributes}')
    with Fmu.read(repack(fmu_path("sampler", version), tmp_path / "x.fmu", edit)) as bounded:
        u, enable = bounded.variables["u"], bounded.variables["enable"]
    assert (u.minimum, u.maximum) == bounds
    assert (enable.minimum, enable.maximum) == (None, None)


@pytest.mark.parametrize(("own", "bounds"), [("", (0.5, 1.0)), (' min="0.75"', (0.75, 1.0))])
def test_a_range_may_be_that_of_the_type(
    fmu_path: Callable[[str, int], Path], tmp_path: Path, own: str, bounds: tuple[float, float]
) -> None:
    def edit(name: str, content: bytes) -> tuple[str, bytes]:
        of_type = b'<TypeDefinitions><Float64Type name="Share" min="0.5" max="1"/>'
        of_variable = f'declaredType="Share"{own} unit="m"'.encode()
        return name, content.replace(b"<TypeDefinitions>", of_type).replace(b'unit="m"', of_variable)

    with Fmu.read(repack(fmu_path("sampler", 3), tmp_path / "x.fmu", edit)) as bounded:
        u = bounded.variables["u"]
    assert (u.minimum, u.maximum) == bounds


def test_roles(fmu: Get) -> None:
    assert role_of(fmu("sampler", 3)) is Role.EVENT
    assert role_of(fmu("sampler", 2)) is Role.SAMPLED
    assert role_of(fmu("integrator", 3)) is Role.CONTINUOUS
    assert role_of(fmu("integrator", 2)) is Role.CONTINUOUS


def _folders() -> set[Path]:
    return set(Path(tempfile.gettempdir()).glob("cosim-*"))


def test_the_temporary_folder_goes_with_the_fmu(
    fmu_path: Callable[[str, int], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    path = fmu_path("integrator", 3)
    with Fmu.read(path) as opened:
        simulate(System([Component("p", opened)]), stop=0.1, output_interval=0.1, tolerance=1e-6)
        assert len(_folders()) == 1
    assert _folders() == set()
    opened.close()
    dropped = Fmu.read(path)
    assert len(_folders()) == 1
    del dropped
    gc.collect()
    assert _folders() == set()


def _feedback(plant: Fmu, controller: Fmu, **parameters: float) -> System:
    return System(
        [Component("plant", plant, {"x0": 1.0}), Component("controller", controller, {"K": -1.0, **parameters})],
        [Connection(("plant", "x"), ("controller", "u")), Connection(("controller", "y"), ("plant", "u"))],
    )


def _resident_bytes() -> int:
    status = Path("/proc/self/statm")
    return int(status.read_text().split()[1]) * 4096 if status.exists() else 0


@pytest.mark.parametrize("version", [2, 3])
def test_five_hundred_runs_in_one_process(
    fmu_path: Callable[[str, int], Path], version: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    before = 0
    for k in range(50):
        with Fmu.read(fmu_path("integrator", version)) as plant, Fmu.read(fmu_path("sampler", version)) as controller:
            for _ in range(10):
                result = simulate(_feedback(plant, controller), stop=0.2, output_interval=0.02, tolerance=1e-6)
                np.testing.assert_allclose(result.columns["plant.x"], 0.98 ** np.arange(11), rtol=1e-12)
        if k == 10:
            gc.collect()
            before = _resident_bytes()
    gc.collect()
    assert _folders() == set()
    assert _resident_bytes() - before < 20e6


@pytest.mark.slow
def test_twenty_five_thousand_instants_take_well_below_a_second(fmu: Get) -> None:
    """10 us per instant with recording on an idle core; the bound leaves room for a busy one."""
    system = _feedback(fmu("integrator"), fmu("sampler"), T_compute=0.001)
    results = [simulate(system, stop=25.0, output_interval=0.001, tolerance=1e-6) for _ in range(3)]
    assert results[0].statistics["exchanges"] == 25001
    assert min(float(str(result.statistics["wall_s"])) for result in results) < 0.75


@pytest.mark.parametrize("version", [2, 3])
def test_what_breaks_the_schema_without_harm_is_read_with_a_warning(
    fmu_path: Callable[[str, int], Path], tmp_path: Path, version: int
) -> None:
    path = repack(
        fmu_path("sampler", version), tmp_path / "x.fmu", replacing('start="0.02"', 'start="0,02" vendor="x"')
    )
    with pytest.warns(FmuWarning) as told, Fmu.read(path) as opened:
        assert opened.variables["T_compute"].start == 0.02
    first, second = (str(warning.message).removeprefix(f"{path}: ") for warning in told)
    assert re.fullmatch(
        r"a start value is not written as the schema demands: T_compute \(line \d\) = '0,02', read as 0.02", first
    )
    assert second.startswith("modelDescription.xml breaks the schema of FMI in one place, line ")

"""What is exported: valid by the published schemas, the same run when read back, and accepted by fmpy."""

from __future__ import annotations

import importlib.util
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssd, read_ssv
from lxml import etree
from typer.testing import CliRunner, Result

from cosim.cli._app import app
from cosim.engine import Component, Connection, Fmu, System
from cosim.errors import InputError
from cosim.fmu import catalogue
from cosim.ssp import read_ssp, write_ssp
from ssp.structures import connector, element, inline, link, real, ssd, wrapped

Paths = Callable[[str, int], Path]
Cosim = Callable[..., Result]

# An integrator that a sampler controls: units differ (m against m), a step, and a linear channel.
PAIR = """# title: A <pair> & more
# system: {plant}
# controller: {controller}
# stop: 1 s
# output_interval: 10 ms
# set: plant.x0 = 30 cm
# set: controller.K = -2
# set: controller.silent = {silent}
# map: plant.x -> controller.u
# map: controller.y -> plant.u
# {linear}
time [ms],controller.enable
0,1
300,0
300,
700,1
"""


@pytest.fixture
def cosim(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Cosim:
    """Run a command in an empty folder."""
    monkeypatch.chdir(tmp_path)
    runner = CliRunner()

    def run(*arguments: str | Path) -> Result:
        done = runner.invoke(app, [str(argument) for argument in arguments])
        assert done.exit_code == 0, done.output
        return done

    return run


def pair(fmu_path: Paths, fmi: int, file: Path) -> Path:
    file.write_text(
        PAIR.format(plant=fmu_path("integrator", fmi), controller=fmu_path("sampler", fmi), silent=0, linear="")
    )
    return file


def exported(cosim: Cosim, scenario: Path, version: str = "1.0") -> tuple[bytes, bytes]:
    """Run a scenario, and what is made of it by export-ssp; return both results.csv."""
    cosim("export-ssp", scenario, "--out", "y.ssp", "--ssp", version)
    cosim("run", scenario, "y_ssp.csv", "--no-plots")
    return tuple(Path("results", name, "results.csv").read_bytes() for name in (scenario.stem, "y_ssp"))  # type: ignore[return-value]


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("version", ["1.0", "2.0"])
def test_a_round_trip_gives_the_same_bytes(
    cosim: Cosim, fmu_path: Paths, tmp_path: Path, fmi: int, version: str
) -> None:
    before, after = exported(cosim, pair(fmu_path, fmi, tmp_path / "a.csv"), version)
    assert before == after
    assert before.count(b"\n") == 102


@pytest.mark.parametrize("name", ["linkage_20ms", "rig_20ms_disturbed"])
def test_a_shipped_scenario_makes_the_round_trip(cosim: Cosim, name: str, tmp_path: Path) -> None:
    pytest.importorskip("rumoca")
    shipped = (catalogue.data_folder() / "scenarios" / f"{name}.csv").read_text()
    (tmp_path / "a.csv").write_text(shipped.replace("stop: 25 s", "stop: 8 s").split("\n9.709")[0] + "\n")
    before, after = exported(cosim, tmp_path / "a.csv")
    assert before == after
    assert before.count(b"\n") == 8002


def test_linear_channels_and_steps_make_the_round_trip(cosim: Cosim, fmu_path: Paths, tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(
        f"# system: {fmu_path('integrator', 3)}\n# controller: none\n# stop: 1 s\n# linear: u\n# set: gain = 0.1\n"
        "time [ms],u [km/h]\n100,1\n200,2\n200,-7.3\n900,0.1\n"
    )
    before, after = exported(cosim, tmp_path / "a.csv")
    assert before == after
    assert Path("y_ssp.csv").read_text().splitlines()[3:6] == ["# tolerance: 1e-06", "# linear: u", "time [s],u [m/s]"]


def test_the_bytes_depend_on_nothing_else(cosim: Cosim, fmu_path: Paths, tmp_path: Path) -> None:
    scenario = pair(fmu_path, 3, tmp_path / "a.csv")
    for name in ("p.ssp", "q.ssp"):
        cosim("export-ssp", scenario, "--out", name)
    assert Path("p.ssp").read_bytes() == Path("q.ssp").read_bytes()


def schema(version: str, kind: str) -> etree.XMLSchema:
    package, folder = {"1.0": ("fmpy", "ssp/schema"), "2.0": ("pyssp_standard", "resources/ssp2")}[version]
    found = importlib.util.find_spec(package)
    assert found is not None and found.origin is not None
    return etree.XMLSchema(file=str(Path(found.origin).parent / folder / f"SystemStructure{kind}.xsd"))


@pytest.mark.parametrize("version", ["1.0", "2.0"])
def test_the_documents_fit_the_published_schemas(cosim: Cosim, fmu_path: Paths, tmp_path: Path, version: str) -> None:
    cosim("export-ssp", pair(fmu_path, 3, tmp_path / "a.csv"), "--ssp", version)
    files = {
        "SystemStructure.ssd": "Description",
        "resources/parameters.ssv": "ParameterValues",
        "resources/parameters.ssm": "ParameterMapping",
    }
    with zipfile.ZipFile("a.ssp") as archive:
        for file, kind in files.items():
            root = etree.fromstring(archive.read(file))
            schema(version, kind).assertValid(root)
            assert root.get("version") == version


def test_fmpy_reads_it(cosim: Cosim, fmu_path: Paths, tmp_path: Path) -> None:
    cosim("export-ssp", pair(fmu_path, 2, tmp_path / "a.csv"))
    read = read_ssd("a.ssp")
    assert [element.name for element in read.system.elements] == ["plant", "controller"]
    assert [(c.name, c.kind) for c in read.system.connectors if c.kind == "input"] == [("enable", "input")]
    (binding,) = read.system.parameterBindings
    assert {p.name: p.value for p in binding.parameterValues[0].parameters} == {
        "plant.x0": "0.3",
        "controller.K": "-2.0",
        "controller.silent": "false",
        "controller.enable": "true",
    }
    assert [entry.target for entry in binding.parameterMapping[0].mappingEntries] == [
        parameter.name for parameter in binding.parameterValues[0].parameters
    ]


def test_fmpy_simulates_it_a_step_late(cosim: Cosim, fmu_path: Paths, tmp_path: Path) -> None:
    """fmpy's master hands on values after each step, and writes those at the end of a step into its beginning's row.

    So with x' = u its row for t_k has the sum of u(t_j) h for j < k, which is x(t_k) where u holds over each step.
    """
    rows = "".join(f"{k / 10},{(k * 7) % 5 - 1.5}\n" for k in range(10))
    (tmp_path / "a.csv").write_text(
        f"# system: {fmu_path('integrator', 2)}\n# controller: none\n# stop: 1 s\n# output_interval: 0.1 s\n"
        f"# set: gain = 3\n# set: x0 = 1 m\ntime [s],u [m/s]\n{rows}"
    )
    cosim("export-ssp", tmp_path / "a.csv")
    cosim("run", "a_ssp.csv", "--no-plots")
    ours = np.genfromtxt(Path("results/a_ssp/results.csv"), delimiter=",", names=True, deletechars="")
    with zipfile.ZipFile("a.ssp") as archive:
        archive.extract("resources/parameters.ssv")
    theirs = simulate_ssp(
        "a.ssp",
        stop_time=0.95,
        step_size=0.1,
        parameter_set=read_ssv("resources/parameters.ssv"),
        input={"u": lambda t: (round(t * 10) * 7) % 5 - 1.5},
    )
    np.testing.assert_allclose(theirs["plant.x"], ours["plant.x_[m]"][: len(theirs)], rtol=1e-12)
    assert len(theirs) == 10


def test_what_was_imported_can_be_exported(cosim: Cosim, fmu_path: Paths, tmp_path: Path) -> None:
    """Nested systems become components with dots in their names; tables, starts and connectors survive."""
    ends = "".join(connector(name, way) for name, way in (("u_Boolean", "input"), ("y_Boolean", "output")))
    table = '<ssc:BooleanMappingTransformation><ssc:MapEntry source="1" target="0"/></ssc:BooleanMappingTransformation>'
    inner = wrapped(
        "Elements", element("m", ends, "mirror.fmu"), element("u", connector("u", "input"), "integrator.fmu")
    )
    structure = ssd(
        wrapped("Connectors", connector("b", "input"), connector("v", "input", "Real", "km/h"))
        + wrapped("ParameterBindings", inline(real("v", 36), real("s.u.gain", 2)))
        + wrapped(
            "Elements",
            f'<ssd:System name="s">{wrapped("Connectors", connector("v", "input"), connector("b", "input"))}{inner}'
            + wrapped("Connections", link("v", "u.u"), link("b", "m.u_Boolean"))
            + "</ssd:System>",
            element("t", ends, "mirror.fmu"),
        )
        + wrapped("Connections", link("b", "s.b"), link("v", "s.v"), link("b", "t.u_Boolean", table))
    )
    (tmp_path / "a.ssd").write_text(structure)
    for name in ("mirror", "integrator"):
        (tmp_path / f"{name}.fmu").write_bytes(fmu_path(name, 3).read_bytes())
    (tmp_path / "a.csv").write_text("# system: a.ssd\n# stop: 1 s\ntime [s],b\n0,1\n0.5,0\n")
    before, after = exported(cosim, tmp_path / "a.csv")
    assert before == after
    header, *rows = before.decode().splitlines()
    assert [column for column in header.split(",") if "Boolean" in column or column.startswith("s.u")] == [
        *("s.m.y_Boolean [1]", "s.u.x [m]", "s.u.y [m/s]", "s.u.positive [1]", "t.y_Boolean [1]"),
        *("s.m.u_Boolean [1]", "t.u_Boolean [1]", "s.u.u [m/s]"),
    ]
    assert float(rows[-1].split(",")[header.split(",").index("s.u.x [m]")]) == pytest.approx(20.0, rel=1e-12)


def test_a_table_on_a_connection_is_written(fmu_path: Paths, tmp_path: Path) -> None:
    with Fmu.read(fmu_path("mirror", 3)) as mirror:
        connections = [
            Connection(("a", f"y_{kind}"), ("b", f"u_{kind}"), table=table)
            for kind, table in {
                "Boolean": ((0.0, 1.0), (1.0, 0.0)),
                "Int8": ((-3.0, 100.0),),
                "Enumeration": ((1.0, 2.0), (2.0, 1.0)),
            }.items()
        ]
        system = System([Component("a", mirror), Component("b", mirror)], connections)
        for version in ("1.0", "2.0"):
            write_ssp(system, tmp_path / "x.ssp", name="x", stop=1.0, version=version)
            assert read_ssp(tmp_path / "x.ssp").connections == connections


def test_fmpy_runs_the_wiper_a_few_steps_late(cosim: Cosim, tmp_path: Path) -> None:
    """Each connection costs fmpy's master a step, which ours does not lose: from duty to current and back, two.

    The crank only turns forwards here, so its angle in fmpy's row for t lies between ours at t - 3 h and at t.
    """
    pytest.importorskip("rumoca")
    plant, controller = (catalogue.ensure(name, "2.0") for name in ("linkage", "voltage_profile"))
    (tmp_path / "a.csv").write_text(
        f"# system: {plant}\n# controller: {controller}\n# stop: 0.6 s\n# output_interval: 1 ms\ntime [s]\n"
    )
    cosim("export-ssp", tmp_path / "a.csv")
    cosim("run", "a_ssp.csv", "--no-plots")
    ours = np.genfromtxt(Path("results/a_ssp/results.csv"), delimiter=",", names=True, deletechars="")
    with zipfile.ZipFile("a.ssp") as archive:
        archive.extract("resources/parameters.ssv")
    theirs = simulate_ssp(
        "a.ssp", stop_time=0.5995, step_size=1e-3, parameter_set=read_ssv("resources/parameters.ssv")
    )["plant.phi_crank"]
    exact = ours["plant.phi_crank_[rad]"][: len(theirs)]
    assert exact[-1] > 1.0
    assert np.all(theirs <= exact + 1e-6)
    assert np.all(theirs[3:] >= exact[:-3] - 1e-6)


def test_options_that_are_refused(fmu_path: Paths, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    scenario = pair(fmu_path, 3, tmp_path / "y_ssp.csv")
    for options, message in {
        ("--ssp", "3.0"): "--ssp 3.0: accepted are 1.0 and 2.0",
        ("--out", "y.zip"): "--out y.zip: give the path of an .ssp file",
        (
            "--out",
            "y.ssp",
        ): "--out y.ssp: y_ssp.csv, which is written beside it, is the scenario itself; give another name",
        ("--set", "plant.x0=1 V"): "--set: '1 V' is in V, 'plant.x0' is in m; write for example 1 m",
    }.items():
        done = CliRunner().invoke(app, ["export-ssp", str(scenario), *options])
        assert (done.exit_code, done.stdout) == (2, "")
        assert done.stderr == f"error: {message}\n"
    assert [path.name for path in tmp_path.iterdir()] == ["y_ssp.csv"]


def test_arrays_are_not_written(fmu_path: Paths, tmp_path: Path) -> None:
    with Fmu.read(fmu_path("vector", 3)) as vector:
        system = System([Component("a", vector), Component("b", vector)], [Connection(("a", "y[1]"), ("b", "u[1]"))])
        with pytest.raises(InputError) as error:
            write_ssp(system, tmp_path / "x.ssp", name="x", stop=1.0)
    assert str(error.value) == (
        "a.y[1] is an element of an array, which an SSP cannot connect alone: none is written; use an FMU with scalars"
    )

"""FMUs with binaries for other platforms than this one: what is chosen, what is in them, when they are built anew."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import lief
import pytest

from cosim.errors import BuildError
from cosim.fmu import catalogue, export
from cosim.fmu.toolchain import PLATFORMS, chosen, fmi_functions, host
from cosim.fmu.versions import FmiVersion

MACHINES = {"x86_64": ("X86_64", "AMD64"), "aarch64": ("AARCH64", "ARM64")}
MODEL = (Path(__file__).parents[2] / "modelica" / "WiperDrive", "WiperDrive.Tests.MotorStart")


def test_what_a_choice_stands_for() -> None:
    assert chosen("host") == (host(),)
    assert chosen("all") == tuple(PLATFORMS.values())
    assert [p.fmi3 for p in chosen("x86_64-windows, aarch64-linux,x86_64-windows")] == [
        "x86_64-windows",
        "aarch64-linux",
    ]
    assert [p.folder("2.0") for p in chosen("all", "2.0")] == ["linux64", "win64", "darwin64"]
    assert [p.folder("2.0") for p in chosen("aarch64-linux", "2.0")] == ["linux64"]


@pytest.mark.parametrize(
    ("choice", "fmi", "message"),
    [
        ("x86_64-linux,sparc", "3.0", f"no platform 'sparc'; there are host, all, {', '.join(PLATFORMS)}"),
        ("", "3.0", f"no platform ''; there are host, all, {', '.join(PLATFORMS)}"),
        (
            "x86_64-darwin,aarch64-darwin",
            "2.0",
            "FMI 2.0 names no processors: x86_64-darwin and aarch64-darwin do not fit into one FMU; choose one of "
            "them, or FMI 3.0",
        ),
    ],
)
def test_choices_that_are_refused(choice: str, fmi: FmiVersion, message: str) -> None:
    with pytest.raises(BuildError) as caught:
        chosen(choice, fmi)
    assert str(caught.value) == message


@pytest.mark.parametrize(
    ("folders", "wanted", "up_to_date"),
    [
        (["x86_64-linux", "aarch64-linux"], {"x86_64-linux"}, True),
        (["x86_64-linux"], {"x86_64-linux", "aarch64-linux"}, False),
    ],
)
def test_an_fmu_for_more_platforms_will_do_and_one_for_fewer_will_not(
    tmp_path: Path, folders: list[str], wanted: set[str], *, up_to_date: bool
) -> None:
    path = tmp_path / "x.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("extra/io.github.wiper-cosim/build.json", json.dumps({"hash": "1"}))
        for folder in folders:
            archive.writestr(f"binaries/{folder}/x.so", "")
    binaries = {f"binaries/{folder}/" for folder in wanted}
    assert catalogue._up_to_date(path, "1", binaries) is up_to_date
    assert not catalogue._up_to_date(path, "2", binaries)


@pytest.mark.slow
@pytest.mark.parametrize("fmi", ["3.0", "2.0"])
def test_all_platforms_in_one_file_with_all_functions_and_the_same_bytes_twice(tmp_path: Path, fmi: FmiVersion) -> None:
    pytest.importorskip("ziglang")
    first, second = (export(*MODEL, tmp_path / name, fmi=fmi, platforms="all") for name in ("a", "b/deeper"))
    assert first.read_bytes() == second.read_bytes()
    with zipfile.ZipFile(first) as archive:
        for target in chosen("all", fmi):
            content = archive.read(f"binaries/{target.folder(fmi)}/MotorStart{target.suffix}")
            library = lief.parse(list(content))
            if isinstance(library, lief.PE.Binary):
                exported = {str(entry.name) for entry in library.get_export().entries}
                machine = library.header.machine.name
            else:
                assert isinstance(library, lief.ELF.Binary | lief.MachO.Binary)
                exported = {str(symbol.name).lstrip("_") for symbol in library.exported_symbols}
                header = library.header
                machine = (header.machine_type if isinstance(library, lief.ELF.Binary) else header.cpu_type).name
            assert set(fmi_functions(fmi)) <= exported
            # nothing but the interface is visible
            assert {name for name in exported if name.startswith("model_") or "simulation" in name} == set()
            assert (
                machine in {"x86_64": ("X86_64", "AMD64"), "aarch64": ("AARCH64", "ARM64")}[target.fmi3.split("-")[0]]
            )


@pytest.mark.slow
def test_the_linkage_for_five_platforms_is_small(tmp_path: Path) -> None:
    pytest.importorskip("ziglang")
    path = export(MODEL[0], "WiperDrive.Systems.LinkagePlant", tmp_path, platforms="all")
    with zipfile.ZipFile(path) as archive:
        binaries = [name for name in archive.namelist() if name.startswith("binaries/")]
    assert len(binaries) == len(PLATFORMS)
    assert path.stat().st_size <= 600_000

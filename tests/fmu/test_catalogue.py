"""Building from the catalogue: what it leaves behind."""

from __future__ import annotations

from pathlib import Path

import platformdirs
import pytest

from cosim.errors import InputError
from cosim.fmu import catalogue, exporter


def test_a_build_leaves_nothing_but_the_fmu(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out, cache = tmp_path / "out", tmp_path / "cache"
    monkeypatch.setattr(platformdirs, "user_cache_dir", lambda name: str(cache))
    monkeypatch.setattr(
        exporter, "export_all", lambda source, model, folder, **_: (folder / "LinkagePlant.fmu").touch()
    )
    assert catalogue.build(["linkage"], out) == [out / "LinkagePlant.fmu"]
    assert [path.name for path in out.iterdir()] == ["LinkagePlant.fmu"]


def test_a_name_that_there_is_not() -> None:
    with pytest.raises(InputError) as caught:
        catalogue.ensure("linkgae")
    assert str(caught.value) == (
        "no built-in plant or controller 'linkgae', did you mean 'linkage'?; built in are linkage, rig, rig_switched, "
        "voltage_profile, s_curve, constant_voltage, ecu, ecu_sampled, speed_control; an FMU of your own is given by "
        "its path, ending in .fmu"
    )


def test_a_target_has_one_lock_however_it_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(platformdirs, "user_cache_dir", lambda name: str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    lock = catalogue._lock
    assert lock(Path("x", "..", "a")) == lock(tmp_path / "a") != lock(tmp_path / "b")
    assert lock(Path("a")).parent == tmp_path / "cache" / "locks"

"""Wrong options of ``cosim calibrate`` are refused before anything is fitted."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from cosim.cli._calibrate import Request, _parameters
from cosim.errors import InputError

if TYPE_CHECKING:
    from cli.conftest import Cosim

UNITS = {"ext_load": "N.m", "d_joint": "N.m.s/rad", "gear.eta_wg": "1"}


def request(
    fit: tuple[str, ...] = (), local: tuple[str, ...] = (), priors: tuple[str, ...] = (), settings: tuple[str, ...] = ()
) -> Request:
    return Request(fit, local, priors, settings, (), (), None, None, False, 10, "shooting")


def test_names_starts_bounds_and_priors_are_read_with_units() -> None:
    free, given, fixed = _parameters(
        request(
            ("plant.ext_load=3000 mN.m:1 N.m..10",), ("d_joint",), ("ext_load=3.5+-0.2 N.m",), ("gear.eta_wg = 0.7",)
        ),
        UNITS,
    )
    assert [(f.name, f.lower, f.upper, f.prior, f.local) for f in free] == [
        ("ext_load", 1.0, 10.0, (3.5, 0.2), False),
        ("d_joint", None, None, None, True),
    ]
    assert given == pytest.approx({"ext_load": 3.0, "gear.eta_wg": 0.7})
    assert fixed == {"gear.eta_wg": 0.7}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"fit": ("ext_lod",)},
            "--fit ext_lod: the plant has no parameter 'ext_lod' that is a number; did you mean ext_load?",
        ),
        ({"fit": ("ext_load:3",)}, "--fit ext_load:3: write NAME, NAME=START, NAME:LOW..HIGH or NAME=START:LOW..HIGH"),
        ({"fit": ("ext_load=much",)}, "--fit ext_load=much: 'much' is not a number, with or without a unit"),
        ({"fit": ("ext_load=3 A",)}, "--fit ext_load=3 A: ext_load is in N.m, not in A"),
        ({"fit": ("ext_load",), "local": ("ext_load",)}, "--local ext_load: ext_load is to be fitted already"),
        (
            {"fit": ("ext_load",), "priors": ("ext_load=3",)},
            "--prior ext_load=3: write NAME=VALUE+-DEVIATION, such as --prior 'gear.eta_wg=0.7+-0.03'",
        ),
        (
            {"fit": ("ext_load",), "priors": ("d_joint=1+-0.1",)},
            "--prior d_joint: it is not fitted; add --fit d_joint",
        ),
        (
            {"fit": ("ext_load",), "settings": ("ext_load=2",)},
            "--set ext_load=2: ext_load is to be fitted; give its start with --fit ext_load=2",
        ),
        ({"fit": ("ext_load",), "settings": ("eta",)}, "--set eta: write NAME=VALUE, such as --set gear.eta_wg=0.7"),
    ],
)
def test_mistakes_are_named(options: dict[str, tuple[str, ...]], message: str) -> None:
    with pytest.raises(InputError) as caught:
        _parameters(request(**options), UNITS)
    assert str(caught.value) == message


def test_files_and_what_to_fit_are_needed(cosim: Cosim) -> None:
    done = cosim("calibrate", "missing.xlsx", "--fit", "ext_load")
    assert done.exit_code == 2
    assert "missing.xlsx: there is no such measurement" in done.stderr
    done = cosim("calibrate", "missing.xlsx")
    assert done.exit_code == 2
    assert "nothing to fit; say what, such as --fit d_joint --fit 'ext_load=3:0..10'" in done.stderr


def test_a_file_that_cannot_be_written_is_found_before_anything_is_fitted(cosim: Cosim, tmp_path: Path) -> None:
    rows = "\n".join(f"{0.002 * k:g},{2.0 * (k > 100):g},24" for k in range(1000))
    (tmp_path / "drive.csv").write_text(f"time [s],current [A],voltage [V]\n{rows}\n")
    (tmp_path / "taken").mkdir()
    (tmp_path / "file").touch()
    for out, message in (("taken", "Is a directory"), ("file/fit.json", "File exists")):
        done = cosim("calibrate", tmp_path / "drive.csv", "--fit", "ext_load", "--out", tmp_path / out)
        assert done.exit_code == 2
        assert f"{tmp_path / out}: cannot be written: {message}" in done.stderr
        assert "iteration" not in done.stderr

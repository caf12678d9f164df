"""Our own FMUs, with all rules: nothing is found."""

from __future__ import annotations

from typing import get_args

import pytest

from cosim.check import check
from cosim.fmu import catalogue
from cosim.fmu.versions import FmiVersion

FIRST = ("linkage", "voltage_profile")


@pytest.mark.parametrize("fmi", get_args(FmiVersion))
@pytest.mark.parametrize(
    "name", [name if name in FIRST else pytest.param(name, marks=pytest.mark.slow) for name in catalogue.names()]
)
def test_nothing_is_found(name: str, fmi: FmiVersion) -> None:
    pytest.importorskip("rumoca")
    report = check(catalogue.ensure(name, fmi))
    assert report.findings == ()
    assert "run.dependencies" in report.applied

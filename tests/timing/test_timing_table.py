"""The timing table of docs/timing.md, row by row, measured with the sampler and the integrator."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from peer_session import OURS, PEERS, Peer, PeerError, interpreter
from peer_timing import Timing, measure

PAGE = Path(__file__).parents[2] / "docs" / "timing.md"
BY_NAME = {peer.name: peer for peer in (*OURS, *PEERS)}
QUICK = {"cosim, gauss-seidel (default)", "cosim, jacobi", "fmpy, loop written by hand", "fmpy, SSP", "fmpy container"}
"""Those that the environment of the tests has anyway."""

NONE = Timing(0, 0, 0, 0, True)
JACOBI = Timing(0, 1, 0, 1, True)
EXPECTED: dict[tuple[str, int, str], Timing] = {
    **{("cosim, gauss-seidel (default)", fmi, first): NONE for fmi in (2, 3) for first in ("plant", "controller")},
    **{("cosim, jacobi", fmi, first): JACOBI for fmi in (2, 3) for first in ("plant", "controller")},
    ("fmpy, loop written by hand", 2, "plant"): JACOBI,
    ("fmpy, loop written by hand", 3, "plant"): JACOBI,
    ("fmpy, SSP", 2, "plant"): Timing(0, 1, -1, 0, False),
    ("fmpy container", 2, "plant"): JACOBI,
    ("fmpy container", 3, "plant"): JACOBI,
    ("fmu-manipulation-toolbox container", 2, "plant"): JACOBI,
    ("fmu-manipulation-toolbox container", 3, "plant"): NONE,
    ("ecos", 2, "plant"): JACOBI,
    ("ecos", 3, "plant"): JACOBI,
    ("libcosim", 2, "plant"): JACOBI,
    ("sofirpy", 2, "plant"): Timing(0, 1, 0, 1, False),
    ("CoFmuPy, jacobi", 2, "plant"): Timing(0, 1, -1, 0, False),
    ("CoFmuPy, jacobi", 3, "plant"): Timing(0, 1, -1, 0, False),
    ("PathSim", 2, "plant"): Timing(-1, 1, 0, 1, True),
    ("PathSim", 2, "controller"): Timing(0, 0, 0, 1, True),
    ("PathSim", 3, "plant"): Timing(-1, 1, 0, 1, True),
    ("PathSim", 3, "controller"): Timing(0, 0, 0, 1, True),
}
REFUSED = [("fmpy, SSP", 3), ("sofirpy", 3), ("libcosim", 3)]


def cases(rows: list[tuple[str, *tuple[object, ...]]]) -> list[object]:
    return [pytest.param(*row, marks=[] if row[0] in QUICK else [pytest.mark.slow]) for row in rows]


def installed(name: str) -> Peer:
    peer = BY_NAME[name]
    if interpreter(peer) is None:
        pytest.skip(f"{peer.module} is not installed; run: python benchmarks/peers.py --install")
    return peer


@pytest.mark.parametrize(("name", "fmi", "first"), cases(list(EXPECTED)))
def test_delays_and_labels(name: str, fmi: int, first: str, tmp_path: Path) -> None:
    timing, _ = measure(installed(name), fmi, tmp_path, controller_first=first == "controller")
    assert timing == EXPECTED[name, fmi, first]


@pytest.mark.parametrize(("name", "fmi"), cases(REFUSED))
def test_systems_that_cannot_run_fmi_3(name: str, fmi: int, tmp_path: Path) -> None:
    with pytest.raises(PeerError):
        measure(installed(name), fmi, tmp_path)


@pytest.mark.parametrize(("name", "fmi", "first"), list(EXPECTED))
def test_the_page_says_the_same(name: str, fmi: int, first: str) -> None:
    timing = EXPECTED[name, fmi, first]
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in PAGE.read_text("utf-8").splitlines()]
    for cells in rows:
        if len(cells) == 7 and cells[0].startswith(name) and str(fmi) in re.findall(r"\d", cells[1]):
            if "first" in cells[0] and f"{first} first" not in cells[0]:
                continue
            shown = [int(cell.replace("\N{MINUS SIGN}", "-")) for cell in cells[2:6]]
            assert shown == [timing.to_controller, timing.to_plant, timing.plant_label, timing.controller_label]
            assert cells[6] == ("plant's output" if timing.first_sees_plant else "start value")
            return
    pytest.fail(f"docs/timing.md has no row for {name}, FMI {fmi}.0, {first} first")

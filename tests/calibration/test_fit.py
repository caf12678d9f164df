"""Fits to data of the tests' own model: what the data tell is found, and what they do not tell is said."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from calibration import plants
from cosim.calibration import Data, Free, data_of, draw_fit, fit, linkage_equations, linkage_model, write_fit
from cosim.calibration._motion import Followed, follow_part, sensitivity_of, sums_of
from cosim.calibration._problem import Problem
from cosim.calibration._uncertainty import Sensitivity
from cosim.dae import Dae
from cosim.errors import InputError
from cosim.measurement import read
from cosim.scenario import read_parameters

pytestmark = pytest.mark.slow
Array = NDArray[np.float64]
TRUE = plants.TRUE
ETA = {"gear.eta_wg": TRUE["gear.eta_wg"]}


@pytest.fixture(scope="module")
def dae() -> Dae:
    return linkage_equations()


@pytest.fixture(scope="module")
def workbooks(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("workbooks")
    return [plants.workbook(folder / f"Motor at {volts:g} V.xlsx", volts, seed=int(volts)) for volts in (21, 24, 27)]


def fitted(dae: Dae, names: list[str], data: list[Data], given: dict[str, float], **options: object):  # type: ignore[no-untyped-def]  # noqa: ANN201
    return fit(linkage_model(names, given, dae), [Free(name) for name in names], data, **options)  # type: ignore[arg-type]


def test_ratios_to_the_efficiency_are_recovered_from_three_workbooks(dae: Dae, workbooks: list[Path]) -> None:
    found = fitted(dae, ["d_joint", "ext_load"], [data_of(read(path)) for path in workbooks], {"J_rotor": 1.3e-4} | ETA)
    assert found.solved
    for name in ("d_joint", "ext_load"):
        assert found.value(name) == pytest.approx(TRUE[name], rel=0.02)
    # with another efficiency taken for granted, the ratio is the same
    other = fitted(dae, ["d_joint", "ext_load"], [data_of(read(workbooks[0]), 1.0)], {"gear.eta_wg": 0.77})
    for name in ("d_joint", "ext_load"):
        assert other.value(name) / 0.77 == pytest.approx(TRUE[name] / TRUE["gear.eta_wg"], rel=0.02)


def test_the_efficiency_alone_is_not_determined_by_workbooks(dae: Dae, workbooks: list[Path]) -> None:
    names = ["d_joint", "ext_load", "gear.eta_wg"]
    found = fitted(dae, names, [data_of(read(path), 1.0) for path in workbooks], {})
    assert found.solved
    (direction,) = found.uncertainty.undetermined
    assert "cannot be told apart: d_joint, ext_load, gear.eta_wg; scaling all by the same factor" in direction.told()
    for name in names[:2]:
        ratio = found.value(name) / found.value("gear.eta_wg")
        assert ratio == pytest.approx(TRUE[name] / TRUE["gear.eta_wg"], rel=0.02)


def test_a_torque_of_its_own_tells_the_efficiency(dae: Dae, tmp_path: Path) -> None:
    data = data_of(read(plants.with_torque(tmp_path / "rig.csv", 24.0)), 1.0)
    assert data.torque is not None
    names = ["d_joint", "ext_load", "gear.eta_wg"]
    found = fitted(dae, names, [data], {})
    assert found.uncertainty.undetermined == []
    for name in names:
        assert found.value(name) == pytest.approx(TRUE[name], rel=0.02)


def test_the_start_tells_the_rotors_inertia_and_steady_running_does_not(dae: Dae, workbooks: list[Path]) -> None:
    names = ["d_joint", "ext_load", "J_rotor"]
    steady = fitted(dae, names, [data_of(read(workbooks[0]), 1.0)], ETA)
    assert [d.parts() for d in steady.uncertainty.undetermined] == [["J_rotor"]]
    start = fitted(dae, names, [data_of(read(workbooks[0]))], ETA)
    assert start.uncertainty.undetermined == []
    assert start.value("J_rotor") == pytest.approx(TRUE["J_rotor"], rel=0.02)


def test_sensitivities_are_those_of_following_again_with_other_parameters(dae: Dae, workbooks: list[Path]) -> None:
    data = data_of(read(workbooks[1]), 1.0, 1.6)
    names = ["d_joint", "ext_load", "gear.eta_wg", "motor.R"]
    problem = Problem(linkage_model(names, ETA, dae), [Free(name) for name in names], [data])
    (part,) = problem.parts
    q = np.concatenate((problem.initial(part), problem.start))

    def followed(at: Array, near: Followed | None) -> tuple[Followed, Sensitivity]:
        found = follow_part(problem, part, at[:3], at[3:], near, tolerance=1e-13)
        return found, sensitivity_of(problem, part, found, len(names))

    # derivatives are as exact as the guess is near
    base, exact = followed(q, followed(q, None)[0])
    slopes = np.hstack((exact.by_state, exact.by_theta))
    h = 1e-6
    for k in range(len(q)):
        sides = [followed(q + sign * h * np.eye(len(q))[k], base)[1].residuals for sign in (1.0, -1.0)]
        differences = (sides[0] - sides[1]) / (2.0 * h)
        assert np.abs(slopes[:, k] - differences).max() <= 1e-6 * np.abs(slopes[:, k]).max(), k
    # the sums that the descent takes are those of these residuals
    sums = sums_of(problem, part, base, np.inf)
    assert sums.squares == pytest.approx(exact.residuals @ exact.residuals, rel=1e-12)
    assert sums.gradient == pytest.approx(slopes.T @ exact.residuals, rel=1e-9)
    assert sums.hessian == pytest.approx(slopes.T @ slopes, rel=1e-9)


@pytest.mark.parametrize("begin", [None, 1.0])
@pytest.mark.parametrize("factor", [0.6, 1.4])
def test_the_minimum_is_found_from_a_motor_constant_that_is_far_off(
    dae: Dae, workbooks: list[Path], begin: float | None, factor: float
) -> None:
    data = [data_of(read(path), begin) for path in workbooks]
    names = ["k_emf", "d_joint", "ext_load", "motor.R"]
    known = {"J_rotor": TRUE["J_rotor"]} | ETA
    near = fitted(dae, names, data, known)
    far = fitted(dae, names, data, known | {"k_emf": 0.113 * factor})
    assert far.solved
    assert far.uncertainty.chi < 1.1
    for one, other in zip(far.estimates, near.estimates, strict=True):
        # what is not known beforehand differs, since each fit is drawn to its own start
        assert one.value == pytest.approx(other.value, abs=0.2 * other.error)


def test_both_methods_find_the_same(dae: Dae, workbooks: list[Path]) -> None:
    names = ["d_joint", "ext_load"]
    data = [data_of(read(workbooks[1]), 1.0, 3.0)]
    shot, collocated = (fitted(dae, names, data, ETA, method=method) for method in ("shooting", "collocation"))
    assert shot.solved and collocated.solved
    for one, other in zip(shot.estimates, collocated.estimates, strict=True):
        assert one.value == pytest.approx(other.value, abs=1e-3 * one.error)
        assert one.error == pytest.approx(other.error, rel=1e-4)


def test_what_the_supply_loses_on_its_way_is_found_and_not_set_in_the_plant(
    dae: Dae, workbooks: list[Path], tmp_path: Path
) -> None:
    data = [data_of(read(path)) for path in workbooks]
    measured_before = [replace(each, supply=each.supply + 0.8) for each in data]
    names = ["d_joint", "ext_load", "supply_drop"]
    found = fitted(dae, names, measured_before, {"J_rotor": TRUE["J_rotor"]} | ETA)
    assert found.value("supply_drop") == pytest.approx(0.8, abs=0.03)
    for name in names[:2]:
        assert found.value(name) == pytest.approx(TRUE[name], rel=0.03)
    document = write_fit(found, tmp_path / "fit.json", {"supply_drop": (0.1, "V")})
    assert [s.name for s in read_parameters(tmp_path / "fit.json")] == ["plant.d_joint", "plant.ext_load"]
    (drop,) = document["local"]  # type: ignore[misc]
    assert (drop["name"], drop["unit"]) == ("supply_drop", "V")


def test_outliers_count_less_in_a_robust_fit(dae: Dae, workbooks: list[Path]) -> None:
    data = data_of(read(workbooks[1]), 1.0)
    current = data.current.copy()
    current[::20] += 2.0
    spoilt = replace(data, current=current)
    names = ["d_joint", "ext_load"]
    error = {
        robust: abs(fitted(dae, names, [spoilt], ETA, robust=robust).value("ext_load") / TRUE["ext_load"] - 1.0)
        for robust in (False, True)
    }
    assert error[True] < 0.02 < error[False]


def test_local_parameters_bounds_priors_and_what_is_held_out(dae: Dae, tmp_path: Path) -> None:
    cold, warm = (
        data_of(read(plants.workbook(tmp_path / f"{name}.xlsx", 24.0, R, seed=3)), 1.0)
        for name, R in (("cold", 1.91), ("warm", 2.25))
    )
    model = linkage_model(["motor.R", "ext_load"], {"d_joint": TRUE["d_joint"]} | ETA, dae)
    free = [Free("motor.R", local=True), Free("ext_load")]
    found = fit(model, free, [cold, warm], held_out=[replace(cold, name="again")])
    assert found.value("motor.R", of=cold.name) == pytest.approx(1.91, rel=0.02)
    assert found.value("motor.R", of=warm.name) == pytest.approx(2.25, rel=0.02)
    assert [a.held_out for a in found.agreements] == [False, False, True]
    # the same data with the same parameters, held out, are met as well as when they are fitted
    assert found.agreements[2].current_rmse == pytest.approx(found.agreements[0].current_rmse, rel=1e-4)

    bounded = fit(model, [Free("motor.R"), Free("ext_load", 2.0, 3.2)], [cold])
    assert bounded.value("ext_load") == pytest.approx(3.2, rel=1e-3)
    assert any("ext_load ends at its bound" in note for note in bounded.notes)

    # a prior as sharp as this decides
    known = fit(model, [Free("motor.R"), Free("ext_load", prior=(3.3, 1e-5))], [cold])
    assert known.value("ext_load") == pytest.approx(3.3, abs=1e-4)


def test_a_fit_that_does_not_converge_says_why_and_marks_its_file(
    dae: Dae, workbooks: list[Path], tmp_path: Path
) -> None:
    names = ["d_joint", "ext_load"]
    found = fitted(dae, names, [data_of(read(workbooks[0]), 1.0, 3.0)], ETA, most_iterations=2)
    assert not found.solved
    assert found.limit == "it took more iterations than allowed"
    write_fit(found, tmp_path / "fit.json", {"gear.eta_wg": (0.7, "1")})
    assert json.loads((tmp_path / "fit.json").read_text())["converged"] is False
    settings = read_parameters(tmp_path / "fit.json")
    assert [s.name for s in settings] == ["plant.d_joint", "plant.ext_load", "plant.gear.eta_wg"]
    assert "NOT CONVERGED: it took more iterations than allowed" in str(settings[0].origin)
    draw_fit(found, tmp_path / "fit.png")
    assert (tmp_path / "fit.png").read_bytes()[:4] == b"\x89PNG"


def test_standing_still_in_the_window_is_refused(dae: Dae, workbooks: list[Path]) -> None:
    data = data_of(read(workbooks[0]), 1.0, 4.0)
    stalled = replace(
        data, current=np.where(data.time > 3.0, 0.0, data.current), supply=np.where(data.time > 3.0, 0.0, data.supply)
    )
    with pytest.raises(InputError) as caught:
        fitted(dae, ["ext_load"], [stalled], ETA)
    assert str(caught.value) == (
        f"{stalled.name}: the motion cannot be followed beyond 3.063 s; at 3.000 s the relation 'bridge.s_diode < 0' "
        "changes. Start from values with which the motor runs as it was measured to, or choose another window"
    )

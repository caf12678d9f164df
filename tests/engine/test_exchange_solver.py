"""The solver for Model Exchange FMUs: accuracy and cost, Jacobians, steps that an FMU refuses, copies of its state."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from coupled_systems import CoupledSystems, exact
from fmu_builder import MODELS, build, edited

from cosim.engine import Algorithm, Component, Connection, Fmu, PartialResultError, Result, System, simulate
from cosim.fmu import catalogue

Get = Callable[..., Fmu]
versions = pytest.mark.parametrize("version", [2, 3])


@pytest.fixture(scope="module")
def variant(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Get]:
    """A test FMU that saves its state, by name, FMI version, whether it gives directional derivatives, and its claims.

    ``claims`` are what its derivatives are said to depend on: "nothing", "states" in truth, or None for no claim.
    """
    folder = tmp_path_factory.mktemp("solver")
    opened: dict[tuple[object, ...], Fmu] = {}

    def get(name: str, fmi: int, *, directions: bool = False, claims: str | None = None) -> Fmu:
        key = name, fmi, directions, claims
        if key not in opened:
            path = folder / str(len(opened))
            path.mkdir()
            built = build(MODELS[name], fmi, path, saves=True, defines=("DIRECTIONAL",) if directions else ())
            opened[key] = Fmu.read(edited(built, path / "claims.fmu", lambda text: claim(text, fmi, claims)))
        return opened[key]

    yield get
    for one in opened.values():
        one.close()


def claim(text: str, fmi: int, claims: str | None) -> str:
    if claims == "nothing":
        return text
    first = '<Unknown index="{}"' if fmi == 2 else '<ContinuousStateDerivative valueReference="{}"'
    for rate, known in ((4, "2"), (5, "1"), (6, "3" if fmi == 2 else "3 0")):
        was = f'{first.format(rate)} dependencies=""'
        text = text.replace(was, was.replace('""', f'"{known}"') if claims else first.format(rate))
    return text


@contextmanager
def loop(name: str) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("COSIM_ENGINE", name)
        yield


def run(fmu: Fmu, tolerance: float, stop: float = 10.0, interval: float = 0.1, **parameters: float) -> Result:
    return simulate(
        System([Component("m", fmu, dict(parameters))]), stop=stop, output_interval=interval, tolerance=tolerance
    )


def error(result: Result) -> float:
    return max(float(np.abs(result.columns[f"m.{name}"] - np.cos(result.time)).max()) for name in ("x", "s"))


def work(result: Result) -> dict[str, int]:
    counts: dict[str, int] = result.statistics["solver"]["m"]  # type: ignore[index]
    return counts


@pytest.mark.parametrize("stiffness", [1.0, 1e5])
@pytest.mark.parametrize("directions", [False, True])
@versions
def test_the_error_is_that_of_the_tolerance_and_costs_what_the_order_says(
    variant: Get, version: int, directions: bool, stiffness: float
) -> None:
    """Errors add up over 10 s; a step h errs by h^5, by the embedded estimate: for a hundredth it takes 100^(1/5) times
    as many steps, up to 100^(1/4) where the order of the stiff component falls."""
    fmu = variant("tracker", version, directions=directions)
    runs = [run(fmu, tolerance, L=stiffness) for tolerance in (1e-4, 1e-6, 1e-8, 1e-10)]
    for result, tolerance in zip(runs, (1e-4, 1e-6, 1e-8, 1e-10), strict=True):
        assert error(result) < 20.0 * tolerance
    for looser, tighter in itertools.pairwise(runs[1:]):
        assert work(tighter)["steps"] < 1.1 * 100 ** (1 / 4) * work(looser)["steps"]
    if directions:
        most = work(runs[-1])
        assert most["rhs_evaluations"] < 11.5 * (most["steps"] + most["rejected_steps"])


@versions
def test_it_agrees_with_cvode_and_the_closed_form(variant: Get, version: int) -> None:
    found = {}
    for name in ("native", "python"):
        with loop(name):
            found[name] = run(variant("tracker", version), 1e-7, L=1e3)
        assert error(found[name]) < 1e-5
    assert work(found["native"])["jacobians"] > 0
    assert "jacobians" not in work(found["python"])


@pytest.mark.parametrize("claims", [None, "states", "nothing"])
@pytest.mark.parametrize("directions", [False, True])
@versions
def test_claims_of_dependencies_save_evaluations_and_do_no_harm(
    variant: Get, version: int, claims: str | None, directions: bool
) -> None:
    """In truth no derivative depends on two states, so that one direction tells of all three."""
    result = run(variant("tracker", version, directions=directions, claims=claims), 1e-6, L=1e4)
    dense = run(variant("tracker", version, directions=directions), 1e-6, L=1e4)
    assert error(result) < 1e-5
    assert work(result)["steps"] == pytest.approx(work(dense)["steps"], rel=0.05)
    saved = work(dense)["rhs_evaluations"] - work(result)["rhs_evaluations"]
    if claims == "states" and not directions:
        assert saved > 1.8 * work(result)["jacobians"]


@pytest.mark.parametrize("directions", [False, True])
@versions
def test_where_the_fmu_discards_a_step_a_shorter_one_is_taken(variant: Get, version: int, directions: bool) -> None:
    """Derivatives exist within 3 ms of the last completed step only."""
    result = run(variant("tracker", version, directions=directions), 1e-6, stop=1.0, near=0.003)
    assert error(result) < 1e-6
    assert 1.0 / 0.003 < work(result)["steps"] < 5.0 / 0.003
    assert work(result)["rejected_steps"] > 0


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        ({"t_hole": 0.52}, r"fmi\d\w+ returned Discard for t = 0\.52"),
        ({"t_nan": 0.52}, r"gives no finite number for the derivative of s at 0\.52"),
        (
            {"grows": 1.0},
            r"cannot be integrated from (0\.99999|1)\S* s on: the step size had to be reduced .* in x;",
        ),
        ({"jumps": 1.0}, r"cannot be integrated from \S+ s on: the last 10,000 steps have covered .* s; .* in v;"),
    ],
)
@versions
def test_why_there_is_no_step_is_said(variant: Get, version: int, parameters: dict[str, float], said: str) -> None:
    with pytest.raises(PartialResultError, match=rf"failed at t = \d.*m \(tracker\): {said}|{said}"):
        run(variant("tracker", version), 1e-8, stop=2.0, **parameters)


@versions
def test_a_run_goes_on_from_a_checkpoint_to_the_same_bytes(variant: Get, version: int, tmp_path: Path) -> None:
    """The solver is ahead of the checkpoint, in the middle of a step, of a flight, of a period of the sampler."""
    system = System(
        [
            Component("ball", variant("ball", version, claims="nothing"), {"T": 0.07}),
            Component("m", variant("tracker", version)),
            Component("relay", variant("relay", version, claims="nothing"), {"T": 0.03}),
        ],
        [Connection(("ball", "h"), ("relay", "u")), Connection(("relay", "y"), ("ball", "u"), factor=0.1)],
    )
    whole = simulate(system, stop=1.0, output_interval=0.01, tolerance=1e-6, checkpoint_at=[0.123, 0.5])
    assert len(whole.checkpoints) == 2
    for checkpoint in whole.checkpoints:
        rest = simulate(system, stop=1.0, output_interval=0.01, tolerance=1e-6, resume=checkpoint)
        for name, column in whole.columns.items():
            assert rest.columns[name].tobytes() == column.tobytes(), name
        assert rest.statistics["solver"] == whole.statistics["solver"]


@pytest.mark.parametrize("name", ["native", "python"])
def test_with_a_controller_with_events_and_a_plant_for_co_simulation(fmu: Get, name: str) -> None:
    """The crank's speed, controlled, is integrated by another FMU: what it has is the crank's angle.

    Plant and integrator exchange at every row; the controller samples without delay, with either plant.
    """
    found = {}
    for interface in ("ModelExchange", "CoSimulation"):
        with (
            loop(name),
            Fmu.read(catalogue.ensure("rig"), interface) as plant,  # type: ignore[arg-type]
            Fmu.read(catalogue.ensure("speed_control")) as controller,
        ):
            system = System(
                [
                    Component("plant", plant),
                    Component("controller", controller),
                    Component("angle", fmu("integrator")),
                ],
                [
                    Connection(("plant", "w_crank"), ("controller", "w_crank")),
                    Connection(("controller", "duty"), ("plant", "duty")),
                    Connection(("plant", "w_crank"), ("angle", "u")),
                ],
            )
            result = simulate(system, stop=1.0, output_interval=1e-3, tolerance=1e-8, algorithm="gauss-seidel")
            found[interface] = result.columns
    for column in ("plant.phi_crank", "controller.duty", "angle.x"):
        assert np.abs(found["ModelExchange"][column] - found["CoSimulation"][column]).max() < 1e-5, column
    angle = found["ModelExchange"]["angle.x"]
    assert angle[-1] == pytest.approx(found["ModelExchange"]["plant.phi_crank"][-1], abs=5e-3)
    assert angle[-1] > 0.1


@versions
def test_short_flights_are_not_stepped_over(variant: Get, version: int) -> None:
    """The ball bounces without loss every 0.9 s, in a run whose fiftieth is twice as long."""
    result = run(variant("ball", version, claims="nothing"), 1e-3, stop=90.0, interval=90.0, e=1.0)
    assert work(result)["state_events"] == math.floor(90.0 / (2.0 * math.sqrt(2.0 / 9.81)) + 0.5)


@pytest.mark.slow
@pytest.mark.parametrize(("algorithm", "step", "within"), [("iterated", 2e-3, 1e-5), ("adaptive", None, 3e-6)])
@versions
def test_algorithms_that_repeat_steps_take_it_back(
    coupled: CoupledSystems, version: int, algorithm: Algorithm, step: float | None, within: float
) -> None:
    """A plant cut into two FMUs, both for Model Exchange, against the matrix exponential."""
    system = coupled.system("oscillator", 3 if version == 3 else 2)
    for component in system.components:
        component.fmu = Fmu.read(component.fmu.path, "ModelExchange")
    result = simulate(system, stop=2.0, output_interval=0.02, tolerance=1e-6, algorithm=algorithm, step=step)
    for name, values in exact("oscillator", result.time).items():
        assert np.abs(result.columns[name] - values).max() < within * np.ptp(values), name
    for component in system.components:
        component.fmu.close()

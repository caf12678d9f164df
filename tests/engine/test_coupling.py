"""Components that act on each other continuously: orders of convergence, tolerances met, loops in time."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest
from both_loops import simulate
from coupled_systems import COUPLED, CoupledSystems, linear

from cosim.engine import Algorithm, Channel, Component, Connection, Fmu, Result, System
from cosim.engine import simulate as simulate_once
from cosim.errors import FmuError, FmuWarning, InputError

Systems = CoupledSystems
Get = Callable[..., Fmu]


@pytest.fixture(scope="module")
def coupled(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Systems]:
    systems = CoupledSystems(tmp_path_factory.mktemp("coupled"))
    yield systems
    systems.close()


def error_of(name: str, result: Result) -> float:
    """Return the largest error of all outputs, each as a share of its range."""
    exact = COUPLED[name].reference(result.time)
    return max(
        float(np.max(np.abs(result.columns[column] - exact[of]))) / float(np.ptp(exact[of]))
        for column, of in COUPLED[name].columns.items()
    )


def algorithm_of(result: Result) -> dict[str, int]:
    found = result.statistics["algorithm"]
    assert isinstance(found, dict)
    return found


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-7])
@pytest.mark.parametrize("name", ["motor", "radiation", pytest.param("oscillator", marks=pytest.mark.slow)])
def test_the_tolerance_is_met(coupled: Systems, name: str, tolerance: float, fmi: int) -> None:
    system = coupled.system(name, fmi)
    result = simulate(system, stop=4.0, output_interval=0.1, tolerance=tolerance, coupling_error=False)
    assert algorithm_of(result)["name"] == "adaptive"
    assert error_of(name, result) <= tolerance
    assert algorithm_of(result)["forced"] <= 4


@pytest.mark.parametrize(
    ("algorithm", "extrapolation", "order"),
    [
        ("extrapolated", 0, 1),
        ("extrapolated", 1, 2),
        ("extrapolated", 2, 2),
        ("iterated", 2, 2),
        ("gauss-seidel", None, 1),
    ],
)
@pytest.mark.parametrize("name", list(COUPLED))
def test_orders(coupled: Systems, name: str, algorithm: Algorithm, extrapolation: int | None, order: int) -> None:
    """The error falls with the power ``order`` of the macro step, whether rows or a step ask for it."""
    errors = []
    for step in (0.02, 0.01, 0.005):
        arguments = {} if extrapolation is None else {"extrapolation": extrapolation}
        result = simulate(
            coupled.system(name),
            stop=2.0,
            output_interval=0.02,
            tolerance=1e-8,
            algorithm=algorithm,
            step=step,
            coupling_error=False,
            **arguments,
        )
        errors.append(error_of(name, result))
    falls = np.log2(np.divide(errors[:-1], errors[1:]))
    assert np.all(falls > order - 0.2), (errors, falls)
    assert np.all(falls < order + 1.2), (errors, falls)


def test_a_divided_interval_is_one_of_as_many_rows(coupled: Systems) -> None:
    """A macro step makes the same numbers as rows that far apart."""
    system = coupled.system("motor")
    arguments = {"stop": 1.0, "tolerance": 1e-8, "algorithm": "extrapolated", "coupling_error": False}
    rows = simulate(system, output_interval=0.01, **arguments)  # type: ignore[arg-type]
    steps = simulate(system, output_interval=0.02, step=0.01, **arguments)  # type: ignore[arg-type]
    for name, column in steps.columns.items():
        np.testing.assert_allclose(column, rows.columns[name][::2], rtol=1e-12, atol=1e-14)
    assert steps.statistics["exchanges"] == rows.statistics["exchanges"] == 101


def test_a_channel_begins_the_polynomials_anew(coupled: Systems) -> None:
    """The voltage doubles at 1 s: the tolerance is met there, too, and the answer doubles from then on."""
    system = coupled.system("motor")
    system.channels = [Channel(("winding", "u"), [0.0, 1.0, 1.0], [1.0, 1.0, 2.0])]
    result = simulate(system, stop=3.0, output_interval=0.05, tolerance=1e-6, coupling_error=False)
    exact = COUPLED["motor"].reference(result.time)
    later = result.time > 1.0
    step = COUPLED["motor"].reference(np.maximum(result.time - 1.0, 0.0))
    for column, of in COUPLED["motor"].columns.items():
        np.testing.assert_allclose(result.columns[column], exact[of] + later * step[of], atol=2e-6)


@pytest.mark.parametrize("fmi", [2, 3])
def test_with_a_sampled_controller(coupled: Systems, fmu: Get, fmi: int) -> None:
    """Between its samples the voltage is constant, and the motor a linear system."""
    system = coupled.system("motor", 3)
    system.components.append(Component("c", fmu("sampler", fmi), {"T_compute": 0.25}))
    system.connections += [Connection(("rotor", "w"), ("c", "u")), Connection(("c", "y"), ("winding", "u"), -0.5, 2.0)]
    result = simulate(system, stop=3.0, output_interval=0.05, tolerance=1e-6, coupling_error=False)
    A = np.array([[-2.0, -2.0], [4.0, -0.4]])  # of Winding and Rotor
    x = np.zeros(2)
    exact = [x]
    for row in range(60):
        if row % 5 == 0:
            u = 2.0 - 0.5 * x[1]
        x = linear(A, np.array([2.0 * u, 0.0]), x, np.array([0.05]))[0]
        exact.append(x)
    np.testing.assert_allclose(result.columns["winding.i"], np.array(exact)[:, 0], atol=2e-6)
    np.testing.assert_allclose(result.columns["rotor.w"], np.array(exact)[:, 1], atol=2e-6)
    assert result.statistics["events" if fmi == 3 else "steps"]["c"] == 13  # type: ignore[index]


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-7])
def test_a_model_exchange_fmu_beside_one_for_co_simulation(coupled: Systems, tolerance: float, fmi: int) -> None:
    system = coupled.system("motor", fmi)
    system.components[0].fmu = Fmu.read(system.components[0].fmu.path, "ModelExchange")
    result = simulate_once(system, stop=4.0, output_interval=0.1, tolerance=tolerance, coupling_error=False)
    assert algorithm_of(result)["name"] == "adaptive"
    assert error_of("motor", result) <= tolerance


def test_what_cannot_go_back_is_told(coupled: Systems, fmu: Get) -> None:
    integrator = fmu("integrator")
    system = System(
        [Component("a", integrator), Component("b", integrator)],
        [Connection(("a", "x"), ("b", "u")), Connection(("b", "x"), ("a", "u"), factor=-1.0)],
    )
    with pytest.warns(FmuWarning, match=r"a \(integrator\) cannot save its state .*, b \(integrator\) cannot"):
        result = simulate(system, stop=0.1, output_interval=0.01, tolerance=1e-6)
    assert algorithm_of(result)["name"] == "extrapolated"
    with pytest.raises(
        FmuError, match=r"the algorithm adaptive repeats steps, but a \(integrator\) cannot .* extrapolated"
    ):
        simulate(system, stop=0.1, output_interval=0.01, tolerance=1e-6, algorithm="adaptive")


def test_systems_without_links_run_as_ever(fmu: Get) -> None:
    integrator = fmu("integrator")
    system = System([Component("a", integrator)])
    for algorithm in ("auto", "adaptive", "iterated"):
        result = simulate(system, stop=0.1, output_interval=0.01, tolerance=1e-6, algorithm=algorithm)  # type: ignore[arg-type]
        assert "algorithm" not in result.statistics


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"algorithm": "euler"}, "algorithm is 'euler'; it can be auto, gauss-seidel, jacobi"),
        ({"algorithm": "jacobi"}, "there is no step; the algorithm jacobi needs the length of its macro steps"),
        ({"step": -1.0}, "step is -1.0; a macro step is above"),
        ({"algorithm": "adaptive", "extrapolation": 3}, "extrapolation is 3, with the algorithm adaptive"),
        ({"algorithm": "jacobi", "step": 0.01, "extrapolation": 1}, "extrapolation is 1, with the algorithm jacobi"),
    ],
)
def test_arguments(coupled: Systems, arguments: dict[str, object], message: str) -> None:
    with pytest.raises(InputError) as caught:
        simulate(coupled.system("motor"), stop=0.1, output_interval=0.01, tolerance=1e-6, **arguments)  # type: ignore[arg-type]
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize("loop", ["native", "python"])
@pytest.mark.parametrize("algorithm", ["extrapolated", "adaptive", "iterated"])
def test_a_run_goes_on_from_a_checkpoint_to_the_same_bytes(
    coupled: Systems, monkeypatch: pytest.MonkeyPatch, algorithm: Algorithm, loop: str
) -> None:
    monkeypatch.setenv("COSIM_ENGINE", loop)
    system = coupled.system("oscillator")
    arguments = {
        "stop": 1.0,
        "output_interval": 0.05,
        "tolerance": 1e-5,
        "algorithm": algorithm,
        "coupling_error": False,
    }
    whole = simulate_once(system, checkpoint_at=[0.37], **arguments)  # type: ignore[arg-type]
    resumed = simulate_once(system, resume=whole.checkpoints[0], **arguments)  # type: ignore[arg-type]
    assert list(resumed.columns) == list(whole.columns)
    for name, column in resumed.columns.items():
        assert column.tobytes() == whole.columns[name].tobytes()
    assert algorithm_of(resumed) == algorithm_of(whole)


def test_in_a_process_of_its_own(coupled: Systems) -> None:
    arguments = {"stop": 1.0, "output_interval": 0.05, "tolerance": 1e-5, "coupling_error": False}
    here = simulate_once(coupled.system("motor"), **arguments)  # type: ignore[arg-type]
    there = simulate_once(coupled.system("motor"), isolate="always", **arguments)  # type: ignore[arg-type]
    assert algorithm_of(here) == algorithm_of(there)
    for name, column in here.columns.items():
        assert column.tobytes() == there.columns[name].tobytes()

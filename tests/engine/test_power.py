"""The energy that a coupling adds, against balances that hold exactly, and what cannot be a power connection."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from both_loops import simulate
from coupled_systems import CoupledSystems
from fmu_builder import INTEGRATOR, build

from cosim.engine import Component, Connection, Fmu, PowerConnection, Result, System
from cosim.engine import simulate as simulate_once
from cosim.errors import InputError

Get = Callable[..., Fmu]

TORQUE = PowerConnection(("winding", "tau"), ("rotor", "w"))
FORCE = PowerConnection(("second", "F"), ("first", "v"))


@pytest.fixture(scope="module", params=[2, 3])
def integrator(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Fmu]:
    """x' = gain u, x without a unit: it may stand for a spring as well as for a mass."""
    variables = (replace(v, unit=None) if v.name == "x" else v for v in INTEGRATOR.variables)
    plain = replace(INTEGRATOR, variables=tuple(variables))
    with Fmu.read(build(plain, request.param, tmp_path_factory.mktemp("plain"))) as opened:
        yield opened


def only(result: Result) -> dict[str, Any]:
    found = result.statistics["power"]
    assert isinstance(found, list)
    (entry,) = found
    return dict(entry)


def spring_and_mass(integrator: Fmu, scale: float = 1.0, sign: float = 1.0) -> System:
    """A spring of 1 N/m that is stretched by 1 m, and a mass of 1 kg that it pulls; the force goes over scaled."""
    return System(
        [
            Component("spring", integrator, {"x0": 1.0}),
            Component("mass", integrator, {"gain": 1.0 / scale}),
        ],
        [Connection(("spring", "x"), ("mass", "u"), factor=-scale), Connection(("mass", "x"), ("spring", "u"))],
        power=[PowerConnection(("spring", "x"), ("mass", "x"), sign)],
    )


def energy(result: Result) -> np.ndarray[Any, np.dtype[np.float64]]:
    return 0.5 * (result.columns["spring.x"] ** 2 + result.columns["mass.x"] ** 2)


def jacobi(system: System, h: float = 0.01) -> Result:
    return simulate(system, stop=2.0, output_interval=h, tolerance=1e-10, algorithm="jacobi", step=h)


def gauss_seidel(system: System, h: float = 0.01) -> Result:
    return simulate(system, stop=2.0, output_interval=h, tolerance=1e-10, algorithm="gauss-seidel")


def test_held_inputs_add_energy_at_a_known_rate(integrator: Fmu) -> None:
    """The explicit Euler method: the energy of the oscillator grows by 1 + h^2 in each step, and that is added."""
    result = jacobi(spring_and_mass(integrator))
    np.testing.assert_allclose(energy(result), 0.5 * (1.0 + 1e-4) ** np.arange(201), rtol=1e-12)
    account = only(result)
    assert account["error_J"] == pytest.approx(0.5 * (1.0 + 1e-4) ** 200 - 0.5, rel=1e-10)
    assert account["error_J"] == pytest.approx(account["taken_J"] - account["given_J"], rel=1e-12)
    # of a quarter of a joule each way, for an angle of 2: that from cos^2/2 to 0, and back up to cos^2(2)/2
    assert account["exchanged_J"] == pytest.approx(0.5 + 0.5 * np.cos(2.0) ** 2, rel=0.02)
    assert account["relative"] == account["error_J"] / account["exchanged_J"]
    assert (account["effort"], account["flow"], account["note"]) == ("spring.x", "mass.x", "")


def test_the_symplectic_order_keeps_the_energy_near_what_it_was(integrator: Fmu) -> None:
    """The spring first, then the mass with the spring's new force: what is added swings, and does not grow."""
    result = gauss_seidel(spring_and_mass(integrator))
    assert only(result)["error_J"] == pytest.approx(energy(result)[-1] - 0.5, rel=1e-9)
    assert np.max(np.abs(energy(result) - 0.5)) < 0.003


def test_the_balance_of_a_motor_without_losses(coupled: CoupledSystems) -> None:
    """What winding and rotor hold is what the supply has given, u times the charge, and what the coupling has added."""
    system = coupled.system("motor")
    system.components[0].parameters["R"] = system.components[1].parameters["d"] = 0.0
    system.power = [TORQUE]
    steps: dict[str, Any] = {"stop": 2.0, "output_interval": 0.02, "tolerance": 1e-9}
    for algorithm in ("jacobi", "gauss-seidel", "extrapolated", "iterated"):
        result = simulate(system, algorithm=algorithm, step=0.02, **steps)
        i, w = result.columns["winding.i"], result.columns["rotor.w"]
        held = 0.5 * 0.5 * i[-1] ** 2 + 0.5 * 0.25 * w[-1] ** 2
        supplied = 1.0 * np.sum(0.5 * (i[1:] + i[:-1])) * 0.02  # the current is a broken line
        assert only(result)["error_J"] == pytest.approx(held - supplied, rel=1e-5, abs=1e-9)


def test_the_tolerance_bounds_what_is_added(coupled: CoupledSystems) -> None:
    system = coupled.system("motor")
    system.power = [TORQUE]
    for tolerance in (1e-3, 1e-5):
        arguments: dict[str, Any] = {"stop": 2.0, "output_interval": 0.1, "tolerance": tolerance}
        account = only(simulate(system, algorithm="adaptive", **arguments))
        assert 0.0 < abs(account["relative"]) < tolerance


def test_scale_and_sign(integrator: Fmu) -> None:
    plain = only(jacobi(spring_and_mass(integrator)))
    scaled = only(jacobi(spring_and_mass(integrator, scale=1000.0)))
    turned = only(jacobi(spring_and_mass(integrator, sign=-1.0)))
    for key in ("given_J", "taken_J", "error_J"):
        assert scaled[key] == pytest.approx(plain[key], rel=1e-9)
        assert turned[key] == -plain[key]
    assert turned["exchanged_J"] == plain["exchanged_J"]


def test_it_falls_with_the_step(coupled: CoupledSystems) -> None:
    """What is added falls with the step, of the first order; the account is that of the run, not of its second one."""
    system = coupled.system("motor", 2)
    system.power = [TORQUE]
    fine, coarse = (gauss_seidel(system, h) for h in (0.01, 0.02))
    assert only(fine)["error_J"] == pytest.approx(0.5 * only(coarse)["error_J"], rel=0.1)
    assert only(fine)["taken_J"] > 0.0


def test_a_resumed_run_has_the_same_account(coupled: CoupledSystems) -> None:
    system = coupled.system("motor")
    system.power = [TORQUE]
    arguments: dict[str, Any] = {"stop": 1.0, "output_interval": 0.02, "tolerance": 1e-6, "coupling_error": False}
    whole = simulate_once(system, checkpoint_at=[0.5], **arguments)
    resumed = simulate_once(system, resume=whole.checkpoints[0], **arguments)
    assert only(resumed) == only(whole)
    with pytest.raises(InputError) as caught:
        simulate_once(coupled.system("motor"), resume=whole.checkpoints[0], **arguments)
    assert "power is not given, in the checkpoint winding.tau * rotor.w" in str(caught.value)


def test_what_depends_directly_is_marked(coupled: CoupledSystems) -> None:
    system = coupled.system("oscillator")
    system.power = [FORCE]
    fine, coarse = (only(gauss_seidel(system, h)) for h in (0.005, 0.01))
    assert fine["note"] == "approximate: second.F depends directly on second.v1"
    assert fine["error_J"] == pytest.approx(0.5 * coarse["error_J"], rel=0.1)


def test_what_acts_at_instants_is_not_measured(integrator: Fmu, fmu: Get) -> None:
    system = System(
        [Component("p", integrator, {"x0": 1.0}), Component("c", fmu("sampler"))],
        [Connection(("p", "x"), ("c", "u")), Connection(("c", "y"), ("p", "u"))],
        power=[PowerConnection(("p", "x"), ("c", "y"))],
    )
    account = only(gauss_seidel(system))
    assert (account["error_J"], account["note"]) == (None, "not measured: c acts at instants")


@pytest.mark.parametrize(
    ("power", "message"),
    [
        (
            PowerConnection(("winding", "tau"), ("rotor", "omega")),
            "rotor.omega: Rotor has no output omega; its outputs are w",
        ),
        (
            PowerConnection(("winding", "i"), ("rotor", "w")),
            "power winding.i * rotor.w: winding.i drives no input of rotor; power goes over one connection each way",
        ),
        (
            PowerConnection(("winding", "tau"), ("winding", "i")),
            "power winding.tau * winding.i: winding.tau drives no input of winding; power goes over one connection "
            "each way",
        ),
        (
            PowerConnection(("winding", "tau"), ("rotor", "w"), 2.0),
            "power winding.tau * rotor.w: its sign is 2; it can be 1 or -1",
        ),
    ],
)
def test_what_is_no_power_connection(coupled: CoupledSystems, power: PowerConnection, message: str) -> None:
    system = coupled.system("motor")
    system.power = [power]
    with pytest.raises(InputError) as caught:
        system.check()
    assert str(caught.value) == message


def test_units_that_make_no_power(coupled: CoupledSystems) -> None:
    system = coupled.system("displacement")
    system.power = [PowerConnection(("first", "x"), ("second", "v"), -1.0)]
    with pytest.raises(InputError) as caught:
        system.check()
    assert str(caught.value) == (
        "power -first.x * second.v: m times m/s is no power; name an effort and a flow, such as a torque [N.m] and an "
        "angular velocity [rad/s]"
    )

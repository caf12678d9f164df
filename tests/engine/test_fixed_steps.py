"""Components that take steps of one length only."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest
from both_loops import simulate
from fmu_builder import INTEGRATOR, build, edited

from cosim.engine import Channel, Component, Connection, Fmu, System, explain_timing
from cosim.errors import FmuWarning, InputError

# that they take steps of one length is said in every run
pytestmark = pytest.mark.filterwarnings("ignore::cosim.errors.FmuWarning")

Get = Callable[..., Fmu]
VARIABLE = 'canHandleVariableCommunicationStepSize="true"'


@pytest.fixture(scope="module", params=[2, 3])
def fixed(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Fmu]:
    """The integrator der(x) = u, which takes steps of 0.1 s only, and says so as either version can."""
    folder = tmp_path_factory.mktemp("fixed")

    def edit(text: str) -> str:
        text = text.replace(VARIABLE, ' fixedInternalStepSize="0.1" ' if request.param == 3 else " ")
        experiment = '<DefaultExperiment stepSize="0.1"/><ModelVariables>'
        return text.replace("<ModelVariables>", experiment) if request.param == 2 else text

    path = edited(build(INTEGRATOR, request.param, folder), folder / "fixed.fmu", edit)
    with Fmu.read(path) as opened:
        yield opened


def test_it_takes_its_own_steps_whatever_the_rows(fixed: Fmu) -> None:
    """Rows and a step of the channel lie between its steps: its outputs hold, an input acts from its next step on."""
    system = System([Component("p", fixed)], channels=[Channel(("p", "u"), [0.0, 0.25], [1.0, 3.0])])
    result = simulate(system, stop=0.65, output_interval=0.05, tolerance=1e-6)
    ends = np.array([0.0, 0.1, 0.2, 0.3, 0.6, 0.9, 1.2])  # at 0, 0.1, ... 0.6
    assert result.columns["p.x"] == pytest.approx(np.repeat(ends, 2), abs=1e-12)
    assert result.statistics["steps"] == {"p": 6}
    assert result.statistics["fixed_step_s"] == {"p": 0.1}


def test_each_step_has_the_inputs_of_its_beginning(fixed: Fmu, fmu: Get) -> None:
    """x' = u with u = t from an integrator before it: a sum over left ends."""
    system = System(
        [Component("ramp", fmu("integrator")), Component("p", fixed)],
        [Connection(("ramp", "x"), ("p", "u"))],
        [Channel(("ramp", "u"), [0.0], [1.0])],
    )
    result = simulate(system, stop=1.0, output_interval=0.1, tolerance=1e-6)
    assert result.columns["p.x"] == pytest.approx([0.01 * k * (k - 1) / 2 for k in range(11)], abs=1e-12)


def test_it_is_said_so(fixed: Fmu) -> None:
    with pytest.warns(FmuWarning) as said:
        simulate(System([Component("p", fixed)]), stop=1.0, output_interval=0.05, tolerance=1e-6)
    assert str(said[0].message) == (
        "p (integrator) takes steps of one length only, 0.1 s: its inputs act from its next step on, and its outputs "
        "hold in between; choose an output interval, sample times and steps of channels that are multiples of it"
    )
    text = explain_timing(System([Component("p", fixed)]), stop=1.0, output_interval=0.03)
    assert "continuous: steps of 0.1 s, the only ones it takes; its outputs hold in between" in text


def test_another_macro_step_is_refused(fixed: Fmu) -> None:
    system = System([Component("p", fixed)])
    with pytest.raises(InputError) as caught:
        simulate(system, stop=1.0, output_interval=0.05, tolerance=1e-6, algorithm="jacobi", step=0.05)
    assert str(caught.value) == (
        "step is 0.05 s, but p (integrator) takes steps of 0.1 s only; choose 0.1 s, or the default algorithm, which "
        "gives each component its own steps"
    )
    result = simulate(system, stop=1.0, output_interval=0.1, tolerance=1e-6, algorithm="jacobi", step=0.1)
    assert result.complete

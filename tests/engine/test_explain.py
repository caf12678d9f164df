"""What ``explain_timing`` says of the sampler and the integrator, and that the sampler has seen the same."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from cosim.engine import Channel, Component, Connection, Fmu, System, explain_timing, simulate
from cosim.errors import SimulationError

Get = Callable[..., Fmu]


def feedback(fmu: Get, version: int = 3, period: float = 0.02) -> System:
    return System(
        [
            Component("plant", fmu("integrator", version), {"x0": 1.0}),
            Component("c", fmu("sampler", version), {"T_compute": period, "K": -1.0}),
        ],
        [Connection(("plant", "x"), ("c", "u")), Connection(("c", "y"), ("plant", "u"), factor=2.0, offset=0.5)],
    )


def test_the_whole_text(fmu: Get) -> None:
    system = feedback(fmu)
    system.channels = [Channel(("c", "enable"), [0.0, 0.033], [1.0, 0.0])]
    assert explain_timing(system, stop=1.0, output_interval=0.01) == (
        "Gauss-Seidel: each component at its own instants, in the order of direct feedthrough. Rows every 0.01 s. "
        "Observed from 0 s to 0.22 s.\n"
        "\n"
        "Components, in the order in which an instant computes them:\n"
        "  plant  continuous: steps of 0.003 s to 0.01 s, each to the next instant or row\n"
        "  c      event: events of its own every 0.02 s, the first at 0 s; events that its inputs cause at 0.033 s\n"
        "\n"
        "Connections:\n"
        "  plant.x -> c.u\n"
        "    delay 0 s; 12 values\n"
        "    1: put out by initialisation at 0 s, acts from 0 s on\n"
        "    0.97: put out at 0.02 s, acts from 0.02 s on\n"
        "    0.95128: put out at 0.033 s, acts from 0.033 s on\n"
        "    0.9412: put out at 0.04 s, acts from 0.04 s on\n"
        "  c.y -> plant.u = 2 * source + 0.5\n"
        "    delay 0 s; 12 values\n"
        "    -1.5: put out at 0 s, acts from 0 s on\n"
        "    -1.44: put out at 0.02 s, acts from 0.02 s on\n"
        "    -1.44: put out at 0.033 s, acts from 0.033 s on\n"
        "    0.5: put out at 0.04 s, acts from 0.04 s on\n"
        "\n"
        "Channels:\n"
        "  channel c.enable, held between entries at 0 s, 0.033 s\n"
        "    delay 0 s; 2 values\n"
        "    1: entered at 0 s, acts from 0 s on\n"
        "    0: entered at 0.033 s, acts from 0.033 s on\n"
    )


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("period", [0.02, 0.0073])
def test_a_sampler_confirms_its_instants_and_that_nothing_is_delayed(fmu: Get, version: int, period: float) -> None:
    text = explain_timing(feedback(fmu, version, period), stop=1.0, output_interval=0.01)
    kind = "event: events of its own" if version == 3 else "sampled: samples"
    assert f"  c      {kind} every {period:g} s, the first at 0 s\n" in text
    assert text.count("    delay 0 s;") == 2
    result = simulate(feedback(fmu, version, period), stop=0.1, output_interval=period, tolerance=1e-6)
    for k, sampled in enumerate(result.columns["c.t_sample"][:4].tolist()):
        x = result.columns["plant.x"][k]
        assert sampled == pytest.approx(k * period, abs=1e-15)
        how = "put out" if k else "put out by initialisation"
        assert f"    {x:.9g}: {how} at {sampled:.9g} s, acts from {sampled:.9g} s on\n" in text
        assert f"    {0.5 - 2.0 * x:.9g}: put out at {sampled:.9g} s, acts from {sampled:.9g} s on\n" in text


def test_an_input_that_waits_for_the_next_sample(fmu: Get) -> None:
    system = feedback(fmu, version=2)
    system.channels = [Channel(("c", "enable"), [0.0, 0.033], [1.0, 0.0])]
    text = explain_timing(system, stop=1.0, output_interval=0.01)
    assert "    delay 0 s to 0.007 s; 2 values\n" in text
    assert "    0: entered at 0.033 s, acts from 0.04 s on\n" in text


def test_jacobi_delays_a_controller_by_one_macro_step(fmu: Get) -> None:
    text = explain_timing(feedback(fmu, version=2), stop=1.0, output_interval=0.01, algorithm="jacobi", step=0.01)
    assert text.startswith("Jacobi: all components in macro steps of 0.01 s, with what all have put out at their begin")
    assert "  c      sampled: macro steps of 0.01 s\n" in text
    plant, controller = text.split("Connections:\n")[1].split("  c.y -> plant.u")
    assert "delay 0 s;" in plant
    assert "delay 0.01 s;" in controller
    assert "    -1.5: put out at 0 s, acts from 0.01 s on\n" in controller


def test_feedthrough_acts_over_the_step_at_whose_end_it_was_put_out(fmu: Get) -> None:
    system = System(
        [Component("b", fmu("integrator")), Component("a", fmu("integrator"))],
        [Connection(("b", "x"), ("a", "u")), Connection(("a", "y"), ("b", "u"), offset=1.0)],
    )
    text = explain_timing(system, stop=0.5, output_interval=0.1)
    assert "  b.x -> a.u\n    delay 0 s; " in text
    assert "  a.y -> b.u = 1 * source + 1\n    delay -0.1 s; 5 values; the source is stepped first, and what it" in text


def test_a_text(fmu: Get) -> None:
    system = System(
        [Component("a", fmu("label"), {"name": "step"}), Component("b", fmu("label"))],
        [Connection(("a", "y"), ("b", "u"))],
    )
    text = explain_timing(system, stop=1.0, output_interval=0.1)
    assert '    "step +": put out at 0.2 s, acts from 0.1 s on\n' in text


def test_a_linear_channel(fmu: Get) -> None:
    system = System(
        [Component("plant", fmu("integrator"))],
        channels=[Channel(("plant", "u"), [0.0, 1.0], [0.0, 2.0], linear=True)],
    )
    text = explain_timing(system, stop=1.0, output_interval=0.1)
    assert (
        "  channel plant.u, interpolated (over a step with the value in its middle) between entries at 0 s, 1 s" in text
    )
    assert "    delay 0 s; 10 values\n" in text
    assert "    0.1: entered at 0 s, acts from 0 s on\n" in text


def test_a_system_that_fails(fmu: Get) -> None:
    with pytest.raises(SimulationError, match=r"at t = 0.04 s: f \(faulty\): fmi3DoStep returned Error"):
        explain_timing(
            System([Component("f", fmu("faulty"), {"fault": "error", "t_fault": 0.05})]), stop=1.0, output_interval=0.01
        )

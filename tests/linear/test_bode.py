"""The Bode picture and python-control's view of the linear system."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest

from cosim.errors import InputError
from cosim.linear import Linearizer, Signal, bode
from cosim.linear._bode import _frequencies, _phase

control = pytest.importorskip("control")


def test_python_control_gets_the_same_system_with_its_names(motor: Linearizer) -> None:
    system = motor.at(inputs={"v": 6.0})
    linear = system.control()
    assert (linear.state_labels, linear.input_labels, linear.output_labels) == (
        ["i", "phi", "w"],
        ["v", "tau"],
        ["i", "w", "P"],
    )
    poles = sorted(control.poles(linear), key=abs)
    np.testing.assert_allclose([p.real for p in system.poles], poles, rtol=1e-12, atol=1e-12)
    # the speed for a constant voltage: k/(R d + k^2)
    without_angle = replace(system, A=np.delete(np.delete(system.A, 1, 0), 1, 1), B=np.delete(system.B, 1, 0),
                            C=np.delete(system.C, 1, 1), states=system.states[::2])  # fmt: skip
    assert control.dcgain(without_angle.control())[1, 0] == pytest.approx(0.1 / (2e-4 + 0.01), rel=1e-12)


def test_the_picture_is_drawn(motor: Linearizer, tmp_path: Path) -> None:
    path = tmp_path / "new" / "motor.png"
    assert bode(motor.at(inputs={"v": 6.0}), path) == []
    height, width, _ = matplotlib.image.imread(path).shape
    assert (width, height) == (1375, 770)


def test_what_has_no_room_is_named(motor: Linearizer, tmp_path: Path) -> None:
    system = motor.at()
    many = tuple(Signal(f"y{k}", "A", 0.0) for k in range(9))
    wide = replace(system, outputs=many, C=np.tile(system.C[:1], (9, 1)), D=np.tile(system.D[:1], (9, 1)))
    assert bode(wide, tmp_path / "x.png") == ["the Bode picture has room for 7 outputs; left out: y7, y8"]


def test_without_a_way_from_an_input_to_an_output_there_is_no_picture(motor: Linearizer, tmp_path: Path) -> None:
    system = motor.at()
    with pytest.raises(InputError, match="Motor: no input reaches an output, so there is no Bode picture"):
        bode(replace(system, B=0 * system.B, D=0 * system.D), tmp_path / "x.png")
    with pytest.raises(InputError, match="Motor has no Real input, so there is no Bode picture"):
        bode(replace(system, B=system.B[:, :0], D=system.D[:, :0], inputs=()), tmp_path / "x.png")


def test_frequencies_span_the_poles(motor: Linearizer) -> None:
    system = motor.at()
    sizes = [pole.frequency for pole in system.poles if pole.frequency]
    omega = _frequencies(system)
    assert omega[0] <= min(sizes) / 10
    assert omega[-1] >= max(sizes) * 10


@pytest.mark.parametrize(
    ("poles", "begins", "ends"), [((1,), 0, -90), ((1, 2, 3), 0, -270), ((0,), -90, -90), ((0, 0), -180, -180)]
)
def test_phases_begin_where_bode_pictures_do(poles: tuple[float, ...], begins: float, ends: float) -> None:
    s = 1j * np.logspace(-6, 6, 2000)
    phase = np.degrees(_phase(1 / np.prod([s + p for p in poles], axis=0)))
    assert (phase[0], phase[-1]) == (pytest.approx(begins, abs=0.01), pytest.approx(ends, abs=0.01))


def test_without_python_control_the_remedy_is_named(
    motor: Linearizer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(InputError) as caught:
        bode(motor.at(), tmp_path / "x.png")
    assert str(caught.value) == "this needs python-control; install it with: pip install 'wiper-cosim[control]'"

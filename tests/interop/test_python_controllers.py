"""Controllers written in Python, made into FMUs by pythonfmu and pythonfmu3."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from cosim.engine import simulate
from cosim.fmu import catalogue
from cosim.scenario import assemble, read

from .conftest import Need

SOURCE = '''
from {package} import {base}Causality as C, {base}Slave, {base}Variability as V, {real} as Real


class Python({base}Slave):
    """The equations of fmus/SpeedController, in its order of operations."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.time = self.w_crank = self.duty = self.error_sum = 0.0
        self.w_ref, self.K_p, self.K_i, self.T_compute = 2.0, 0.2, 0.6, 0.01
        {time}
        self.register_variable(Real("w_crank", causality=C.input, variability=V.discrete))
        self.register_variable(Real("duty", causality=C.output, variability=V.discrete))
        for name in ("w_ref", "K_p", "K_i", "T_compute"):
            self.register_variable(Real(name, causality=C.parameter, variability=V.fixed))

    def do_step(self, t, h):
        error = self.w_ref - self.w_crank
        duty = self.K_p * error + self.K_i * self.error_sum
        self.duty = min(max(duty, 0.0), 1.0)
        if self.duty == duty:
            self.error_sum += self.T_compute * error
        return True
'''
INDEPENDENT = 'self.register_variable(Real("time", causality=C.independent, variability=V.continuous))'
VERSIONS = {
    "pythonfmu": SOURCE.format(package="pythonfmu", base="Fmi2", real="Real", time="pass"),
    "pythonfmu3": SOURCE.format(package="pythonfmu3", base="Fmi3", real="Float64", time=INDEPENDENT),
}
SCENARIO = """# system: rig
# controller: {controller}
# stop: 5 s
# set: controller.w_ref = 1.5 rad/s
time [s],tau_disturbance [N.m]
0,0
2,-3
2.5,0
"""


def run(controller: str, folder: Path) -> dict[str, np.ndarray]:
    path = folder / f"{Path(controller).stem}.csv"
    text = SCENARIO.format(controller=controller)
    if not controller.endswith(".fmu"):
        path.write_text(text)
    else:
        path.write_text(text.replace("rad/s", ""))  # pythonfmu knows no units
    scenario = read(path)
    system = assemble(scenario, catalogue.ensure)
    result = simulate(system, stop=scenario.stop, output_interval=1e-3, tolerance=1e-6)
    return {"time": result.time} | result.columns


@pytest.mark.parametrize("package", VERSIONS)
def test_a_controller_in_python_equals_the_same_in_c(need: Need, package: str, tmp_path: Path) -> None:
    """Sampled at the same instants, without delay, with the same operations: equal in every bit."""
    need(package)
    module = f"controller_for_{package}.py"  # both are imported into this very process
    (tmp_path / module).write_text(VERSIONS[package])
    build = [sys.executable, "-m", package, "build", "-f", module, "-d", str(tmp_path)]
    subprocess.run(build, check=True, capture_output=True, timeout=120, cwd=tmp_path)
    in_python, in_c = run("Python.fmu", tmp_path), run("speed_control", tmp_path)
    assert in_python["controller.duty"].max() > 0.3
    for name in ("plant.phi_crank", "plant.w_crank", "plant.i_motor", "controller.duty"):
        assert np.array_equal(in_python[name], in_c[name]), name

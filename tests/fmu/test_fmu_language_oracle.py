"""The numbers that the pieces of the language must give, once more from rumoca's own simulator."""

from __future__ import annotations

import re

import pytest

from fmu import test_fmu_algorithmic as algorithmic
from fmu import test_fmu_language as language

rumoca = pytest.importorskip("rumoca")

EXPECTED = {"Language": language.EXPECTED, "Algorithmic": algorithmic.EXPECTED}
CANNOT = {
    "derWhen": "rumoca: derivative coordinate escaped checked structural substitution",
    "momentum": "rumoca takes der() of variables only",
    "oscillator": "rumoca takes der() of variables only",
    "preInput": "rumoca wants a value for the input, which the top model gives",
    "shapes": "rumoca has no power of a matrix",
}
DIFFER = {
    "ends.t": "rumoca sums one element of v[2:end]",
    "algorithms.up": "rumoca's when-statement sees n before the event, although n depends on the same event",
}


def component_classes(model: str) -> dict[str, str]:
    text = (algorithmic.MODELS / f"{model}.mo").read_text()
    return {name: kind for kind, name in re.findall(r'^  (\w+) (\w+)(?:\(.*\))? ".*";$', text, re.MULTILINE)}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("model", "component"), [(model, name) for model, table in EXPECTED.items() for name in sorted(table)]
)
def test_rumocas_simulator_gives_the_same(model: str, component: str) -> None:
    if component in CANNOT:
        pytest.skip(CANNOT[component])
    text = (algorithmic.MODELS / f"{model}.mo").read_text()
    compiled = rumoca.Session().loads(
        text, model=f"{model}.{component_classes(model)[component]}", filename="no-such-folder/model.mo"
    )
    config = rumoca.SimConfig(rtol=1e-8, atol=1e-10)
    result = compiled.simulate(algorithmic.T, dt=algorithmic.T / 200, config=config)
    compared = {
        name: value
        for name, value in EXPECTED[model][component].items()
        if name in result.names and f"{component}.{name}" not in DIFFER  # parameters are not among the results
    }
    assert compared or all(name in compiled.parameters.names for name in EXPECTED[model][component])
    found = {name: float(result[name][-1]) for name in compared}
    assert found == pytest.approx(compared, rel=1e-4, abs=1e-4)

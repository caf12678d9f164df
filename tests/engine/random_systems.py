"""Systems of test FMUs at random, for what has to hold for all."""

from __future__ import annotations

from collections.abc import Callable

from hypothesis import strategies as st

from cosim.engine import Channel, Component, Connection, Fmu, System

Get = Callable[..., Fmu]

PERIODS = st.sampled_from([0.001, 0.002, 0.0073, 0.01, 0.0105, 0.02]) | st.floats(0.0005, 0.05)
NUMBERS = st.floats(-3.0, 3.0)
OUTPUTS = {"sampler": ("y", "t_sample", "count", "side"), "integrator": ("x", "y", "positive")}


@st.composite
def systems(draw: st.DrawFn, get: Get) -> System:
    """Up to four components, each input driven by another component, a channel or nothing."""
    kinds = draw(st.lists(st.sampled_from(["sampler", "integrator"]), min_size=1, max_size=4))
    components = [_component(draw, get, f"c{i}", kind) for i, kind in enumerate(kinds)]
    system = System(components)
    for component, kind in zip(components, kinds, strict=True):
        driver = draw(st.sampled_from(["component", "hold", "line", "nothing"]))
        target = (component.name, "u")
        source = draw(st.integers(0, len(kinds) - 1))
        output = draw(st.sampled_from(OUTPUTS[kinds[source]]))
        if driver == "component" and (kind == "sampler" or output != "y"):
            connection = Connection((components[source].name, output), target, draw(NUMBERS), draw(NUMBERS))
            system.connections.append(connection)
        elif driver in ("hold", "line"):
            times = sorted(draw(st.lists(st.floats(0.0, 0.12), min_size=1, max_size=6, unique=True)))
            values = [draw(NUMBERS) for _ in times]
            system.channels.append(Channel(target, times, values, linear=driver == "line"))
    return system


def _component(draw: st.DrawFn, get: Get, name: str, kind: str) -> Component:
    fmu = get(kind, draw(st.sampled_from([2, 3])))
    if kind == "sampler":
        return Component(name, fmu, {"T_compute": draw(PERIODS), "K": draw(NUMBERS), "silent": draw(st.booleans())})
    return Component(name, fmu, {"x0": draw(NUMBERS), "gain": draw(NUMBERS)})

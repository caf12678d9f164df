"""Finds out when an FMU without event mode samples: it is run alone, and asked when its outputs answer its inputs.

Such an FMU executes a sample inside doStep(t, h), at t or at t + h, and its model description does not say which; nor
does it say for how many samples an answer is held back. What the engine makes of it is in ``Role``.
"""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass

from cosim.engine.exchange._instances import instantiate
from cosim.engine.fmu._calls import Site
from cosim.engine.fmu._instance import CallError, Instance
from cosim.engine.fmu._variable import OPAQUE, Value, Variable
from cosim.engine.system._parameters import parameters_of
from cosim.engine.system._system import Component

_BEGINNINGS = (2, 11, 50)
"""Samples at which inputs are changed, each in a run of its own: a controller may be deaf for a while."""

_PATIENCE = 50
"""Samples within which an answer counts as one."""

_TOLERANCE = 1e-6


@dataclass(frozen=True)
class Answer:
    """The quickest answer of any output to a change of all inputs.

    ``samples`` is how many samples it came late, None if it never came; ``at_end`` tells whether it came in the second
    half of the sample period, None if the FMU does not take steps of half a period.
    """

    samples: int | None
    at_end: bool | None

    def sentence(self, period: float) -> str:
        """Return what this means for a component that is sampled every ``period`` [s]."""
        if self.samples is None:
            return f"probed: no answer to its inputs was seen within {_PATIENCE} samples"
        late = f"{self.samples} samples" if self.samples > 1 else "1 sample" if self.samples else "the same sample"
        answers = f"its outputs answer its inputs {'with' if self.samples == 0 else 'after'} {late}"
        delay = f"{answers}: a delay of {self.samples * period:.9g} s inside it"
        if self.at_end is None:
            return f"probed: {delay}; whether it computes at the start or at the end of its steps cannot be seen"
        if self.at_end:
            return (
                f"probed: it computes at the end of its steps, so that its own time is {period:.9g} s ahead of the "
                f"instants at which it is sampled; {delay}"
            )
        return f"probed: it computes at the start of its steps; {delay}"


def probe(component: Component, period: float, site: Site | None = None) -> str:
    """Return a sentence on the delay between inputs and outputs of a component, sampled every ``period`` [s]."""
    if component.fmu.capabilities["canBeInstantiatedOnlyOncePerProcess"]:
        return "not probed, since it can be used only once in a process"
    halves = 2 if component.fmu.capabilities["canHandleVariableCommunicationStepSize"] else 1
    found: list[tuple[int, bool | None]] = []
    try:
        for beginning in _BEGINNINGS:
            late = _first_difference(component, period, halves, beginning, site)
            if late is not None:
                found.append((late // halves, late % halves == 1 if halves > 1 else None))
    except CallError as error:
        return f"could not be probed: alone, it {error.what}"
    answer = Answer(*min(found, key=lambda pair: pair[0])) if found else Answer(None, None)
    return answer.sentence(period)


def _first_difference(component: Component, period: float, parts: int, beginning: int, site: Site | None) -> int | None:
    """Return how many steps of ``period / parts`` after the one that sees changed inputs outputs differ, if they do."""
    outputs = [v.name for v in component.fmu.variables.values() if v.causality == "output" and v.type not in OPAQUE]
    with ExitStack() as stack:
        instances: list[Instance] = []
        for kind in ("undisturbed", "disturbed"):
            instance = instantiate(f"{component.name} ({kind})", component.fmu, False, site)
            stack.callback(instance.free)
            instance.set_values(parameters_of(component))
            instance.enter_initialization(_TOLERANCE, None)
            instance.exit_initialization()
            instances.append(instance)
        step = period / parts
        for k in range(parts * (beginning + _PATIENCE)):
            if k == parts * beginning:
                instances[1].set_values(_changed(component))
            for instance in instances:
                instance.t.value, instance.h.value = k * step, step
                instance.check("DoStep", instance.do_step())
            undisturbed, disturbed = ([instance.get_value(name) for name in outputs] for instance in instances)
            if undisturbed != disturbed:
                return k - parts * beginning
    return None


def _changed(component: Component) -> dict[str, Value]:
    """Return other values for all inputs that are numbers."""
    inputs = [v for v in component.fmu.variables.values() if v.causality == "input" and v.type not in OPAQUE]
    return {variable.name: _other(variable) for variable in inputs}


def _other(variable: Variable) -> Value:
    start = variable.start if isinstance(variable.start, int | float) else 0
    if variable.type == "Boolean":
        return not start
    above = start + 1
    return start - 1 if variable.maximum is not None and above > variable.maximum else above

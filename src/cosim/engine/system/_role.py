"""How a component takes part in time: at its own events, at its own samples, or continuously."""

from __future__ import annotations

import enum
import math
import warnings
from collections.abc import Iterable

from cosim.engine.fmu._fmu import Fmu
from cosim.engine.system._system import SAME_INSTANT, Component
from cosim.errors import FmuError, FmuWarning

_PERIOD = "T_compute"


class Role(enum.Enum):
    """When a component is computed.

    A component is discrete if its model description lists no continuous state, and either none of its outputs is
    continuous or it has a parameter ``T_compute``. A discrete component with an event mode (FMI 3.0) announces its own
    events. Any other discrete component that has inputs is sampled: its doStep(t, h) executes the sample at t and holds
    the outputs until t + h, with h = ``T_compute``, or the one step that it can take, or the output interval; a change
    of its inputs in between waits for its next sample. All else is continuous and is run without event mode: the
    outputs after doStep(t, h) are those at t + h. One that takes steps of one length only takes these, each with the
    inputs that it had at the beginning, and its outputs hold in between.
    """

    EVENT = "event"
    SAMPLED = "sampled"
    CONTINUOUS = "continuous"


def role_of(fmu: Fmu) -> Role:
    """Return the role that the model description of an FMU implies."""
    outputs = [variable for variable in fmu.variables.values() if variable.causality == "output"]
    all_discrete = bool(outputs) and all(variable.variability != "continuous" for variable in outputs)
    if fmu.has_continuous_states or not (all_discrete or has_period(fmu)):
        return Role.CONTINUOUS
    if fmu.has_event_mode:
        return Role.EVENT
    has_inputs = any(variable.causality == "input" for variable in fmu.variables.values())
    return Role.SAMPLED if has_inputs else Role.CONTINUOUS


def period_of(component: Component, output_interval: float) -> float:
    """Return the sample period [s] of a sampled component; raises FmuError if it is not positive."""
    if not has_period(component.fmu):
        return component.fmu.fixed_step or output_interval
    value = component.parameters.get(_PERIOD, component.fmu.variables[_PERIOD].start)
    if not isinstance(value, int | float) or not value > 2.0 * SAME_INSTANT:
        raise FmuError(f"{component.name}.{_PERIOD}: is {value}; a sample period must be above {2.0 * SAME_INSTANT} s")
    return float(value)


def sample_period(component: Component, output_interval: float) -> float | None:
    """Return the sample period [s] of a component; None if it has none, or announces its instants while it runs."""
    if has_period(component.fmu) or role_of(component.fmu) is Role.SAMPLED:
        return period_of(component, output_interval)
    return None


def fixed_step_of(component: Component, output_interval: float) -> float:
    """Return the length [s] of the steps of a continuous component; infinite if it takes steps of any length."""
    if component.fmu.capabilities["canHandleVariableCommunicationStepSize"]:
        return math.inf
    return component.fmu.fixed_step or output_interval


def has_period(fmu: Fmu) -> bool:
    """Tell whether an FMU says by a parameter how often it computes."""
    variable = fmu.variables.get(_PERIOD)
    return variable is not None and variable.causality == "parameter" and variable.type == "Real"


def warn_of_fixed_steps(components: Iterable[Component], output_interval: float) -> None:
    """Warn (FmuWarning) of continuous components that take steps of one length only [s]: they see others late."""
    for component in components:
        step = fixed_step_of(component, output_interval)
        if role_of(component.fmu) is Role.CONTINUOUS and step < math.inf:
            which = "" if component.fmu.fixed_step else " (the output interval, since it does not say which)"
            warnings.warn(
                f"{component.name} ({component.fmu.name}) takes steps of one length only, {step:g} s{which}: its "
                "inputs act from its next step on, and its outputs hold in between; choose an output interval, sample "
                "times and steps of channels that are multiples of it",
                FmuWarning,
                stacklevel=4,
            )

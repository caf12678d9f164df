"""What is asked for, checked before anything runs."""

from __future__ import annotations

from cosim.engine._execution import Job
from cosim.engine.loop._plan import roles_of
from cosim.engine.system._arguments import check_arguments, check_fixed_steps
from cosim.engine.system._method import Algorithm, choose
from cosim.engine.system._parameters import parameters_of
from cosim.engine.system._role import warn_of_fixed_steps
from cosim.engine.system._system import System


def prepared(
    system: System,
    *,
    stop: float,
    output_interval: float,
    tolerance: float,
    algorithm: Algorithm,
    step: float | None,
    extrapolation: int | None,
) -> Job:
    """Check what ``simulate`` is asked for, with the same arguments; return what is to be done.

    Whoever calls it is called by the user, whom warnings are for.
    """
    check_arguments(stop, output_interval, tolerance)
    system.check()
    method = choose(
        system,
        roles_of(system),
        algorithm,
        step=step,
        extrapolation=extrapolation,
        stop=stop,
        output_interval=output_interval,
    )
    if method.is_fixed:
        check_fixed_steps(system, step)
    else:
        warn_of_fixed_steps(system.components, output_interval)
    for component in system.components:
        parameters_of(component)
    return Job(system, stop, output_interval, tolerance, method)

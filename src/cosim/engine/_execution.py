"""One run of a system: instances made, initialised, simulated, freed; in whatever process this is called."""

from __future__ import annotations

import math
import threading
import time
from array import array
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field

from cosim.engine.checkpoints._checkpoint import Checkpoint
from cosim.engine.checkpoints._resume import NotWrittenError, Saving, apply, forget, restore, save
from cosim.engine.coupling._coupling_memory import CouplingMemory
from cosim.engine.exchange._instances import instantiate
from cosim.engine.fmu._calls import Site
from cosim.engine.fmu._instance import CallError, Instance
from cosim.engine.loop._couple import couple
from cosim.engine.loop._initialize import initialize
from cosim.engine.loop._loop import run, run_jacobi
from cosim.engine.loop._native import run_native
from cosim.engine.loop._plan import Plan, make_plan, roles_of
from cosim.engine.loop._record import Record, failure_message
from cosim.engine.loop._setup import Setting
from cosim.engine.native._library import native_library
from cosim.engine.system._arguments import LEAST_TOLERANCE
from cosim.engine.system._method import Method
from cosim.engine.system._parameters import parameters_of
from cosim.engine.system._role import Role
from cosim.engine.system._system import Component, System
from cosim.errors import FmuError

_WITHIN = 0.01
"""Tolerance of the FMUs where the errors of coupling are adapted to that of the run, of which it is this part."""
_COUNTERS = ("steps", "rejected_steps", "rhs_evaluations", "jacobians", "state_events", "time_events")


@dataclass(frozen=True)
class Job:
    """What is to be simulated, checked; times in s. ``saving`` is None if nothing is saved and the run begins at 0."""

    system: System
    stop: float
    output_interval: float
    tolerance: float
    method: Method = field(default_factory=lambda: Method("gauss-seidel"))
    saving: Saving | None = None

    @property
    def step(self) -> float | None:
        """The macro step [s] of the Jacobi algorithm; None for the others, which heed the roles of components."""
        return self.method.step if self.method.is_fixed else None

    @property
    def settings(self) -> dict[str, Setting]:
        """What has to be the same where a run goes on from a checkpoint, besides the system."""
        return {
            "output_interval": self.output_interval,
            "tolerance": self.tolerance,
            "algorithm": self.method.algorithm,
            "step": self.method.step,
            "extrapolation": self.method.order,
            "parts": self.method.parts,
            **({"power": ", ".join(map(str, self.system.power))} if self.system.power else {}),
        }


@dataclass
class Ending:
    """How a run ended: ``statistics`` as in ``Result``; ``message`` says why it ended before its time.

    ``checkpoints`` are those that were kept in memory, ``remarks`` what the user should know about initialisation.
    """

    statistics: dict[str, object]
    message: str | None = None
    interrupted: bool = False
    checkpoints: list[Checkpoint] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)


def loop_name() -> str:
    """Return which loop runs in this process, "native" or "python"; raises as ``native_library`` does."""
    return "native" if native_library() else "python"


@contextmanager
def instantiated(job: Job, sites: Sequence[Site]) -> Iterator[Plan]:
    """Give the plan of a run, with instances that note their calls at their component's site, and free them at the end.

    Raises FmuError if an FMU cannot be loaded or instantiated.
    """
    system = job.system
    roles = roles_of(system) if job.step is None else {c.name: Role.CONTINUOUS for c in system.components}
    instances: dict[str, Instance] = {}
    once = [c for c in system.components if c.fmu.capabilities["canBeInstantiatedOnlyOncePerProcess"]]
    with ExitStack() as claims:
        for component in once:
            claims.enter_context(_claimed(component))
        try:
            for component, site in zip(system.components, sites, strict=True):
                event_mode = roles[component.name] is Role.EVENT
                instances[component.name] = instantiate(component.name, component.fmu, event_mode, site)
            plan = make_plan(system, roles, instances, job.output_interval, job.stop)
            try:
                yield plan
            finally:
                if plan.coupling is not None:
                    plan.coupling.free()
        finally:
            for instance in instances.values():
                instance.free()


_in_use: dict[str, str] = {}
_claiming = threading.Lock()


@contextmanager
def _claimed(component: Component) -> Iterator[None]:
    """Keep other runs of this process from an FMU that it may have one instance of; raises FmuError if one has it."""
    key = component.fmu.sha256
    with _claiming:
        if key in _in_use:
            raise FmuError(
                f"{component.name} ({component.fmu.name}) can be used only once in a process, and another run that has "
                f"not ended uses it as {_in_use[key]}; let that end first, or run this one in a process of its own",
                file=component.fmu.path,
            )
        _in_use[key] = component.name
    try:
        yield
    finally:
        with _claiming:
            del _in_use[key]


def execute(job: Job, plan: Plan, record: Record, progress: Callable[[float], None] | None) -> Ending:
    """Initialise, or go on from a checkpoint, and simulate; the rows are in ``record``, whatever happens.

    Raises InputError (FmuError) if a component refuses its parameters, or if the checkpoint does not fit.
    """
    clock = Clock()
    ending = Ending({})
    broken: Instance | None = None
    saving = job.saving
    try:
        if saving is not None:
            forget(saving)
        ending.remarks = begin(job, plan, record)
        clock.start()
        for at in saving.at if saving else ():
            simulate_to(at, job, plan, record, progress)
            clock.stop()
            assert saving is not None
            ending.checkpoints.append(save(plan, record, job.system, job.settings, saving, at))
            clock.start()
        simulate_to(math.inf, job, plan, record, progress)
    except CallError as failure:
        broken = failure.instance
        ending.message = failure_message(failure, record)
    except NotWrittenError as failure:
        ending.message = f"the simulation ended at t = {record.now:.9g} s: {failure}"
    except KeyboardInterrupt:
        ending.message, ending.interrupted = interruption_message(record), True
    clock.stop()
    if plan.coupling is not None:
        ending.remarks = [*ending.remarks, *plan.coupling.remarks]
    ending.statistics = statistics(plan, record, clock.seconds, broken)
    if job.saving and job.saving.resume:
        ending.statistics["resumed_at_s"] = job.saving.resume.time
    return ending


def begin(job: Job, plan: Plan, record: Record) -> list[str]:
    """Bring a plan with new instances to where the run begins; return what the user should know of that.

    Raises as ``execute`` does, and CallError.
    """
    saving = job.saving
    if saving and saving.resume:
        _couple(job, plan)
        restore(saving.resume, plan, record, job.tolerance)
        apply(saving.parameters or {}, plan, record, job.step)
        return []
    for component in job.system.components:
        participant = next(p for p in (*plan.continuous, *plan.discrete) if p.instance.name == component.name)
        participant.instance.set_values(parameters_of(component))
    horizon = saving.horizon if saving else job.stop
    tolerance = max(_WITHIN * job.tolerance, LEAST_TOLERANCE) if job.method.is_coupled else job.tolerance
    remarks = initialize(plan, job.system, tolerance, horizon if math.isfinite(horizon) else None)
    _couple(job, plan)
    return remarks


def _couple(job: Job, plan: Plan) -> None:
    if job.method.is_coupled:
        horizon = job.saving.horizon if job.saving and math.isfinite(job.saving.horizon) else job.stop
        plan.coupling = couple(job.system, plan, job.method, job.tolerance, horizon)
        plan.memory["coupling"] = CouplingMemory(plan.coupling)


def simulate_to(
    pause: float, job: Job, plan: Plan, record: Record, progress: Callable[[float], None] | None = None
) -> None:
    """Go on to the first communication point at or after ``pause`` [s], or to the end; raises CallError."""
    if record.count == len(record.grid):
        return
    library = native_library(record.loop)
    if library is not None:
        run_native(library, plan, record, job.method, progress, pause)
    elif job.step is not None:
        run_jacobi(plan, record, job.step, progress, pause)
    else:
        run(plan, record, job.method, progress, pause)


class Clock:
    """Adds up the wall time [s] between starts and stops."""

    def __init__(self) -> None:
        """Stand still."""
        self.seconds = 0.0
        self._since: float | None = None

    def start(self) -> None:
        """Go on."""
        self._since = time.perf_counter()

    def stop(self) -> None:
        """Stand still, if it does not."""
        if self._since is not None:
            self.seconds += time.perf_counter() - self._since
            self._since = None


def interruption_message(record: Record) -> str:
    """Return what the user reads after Ctrl-C."""
    return f"the simulation was interrupted at t = {record.now:.9g} s"


def statistics(plan: Plan, record: Record, wall: float, broken: Instance | None = None) -> dict[str, object]:
    """Return what is counted, as in ``Result``; ``wall`` [s] is the time of the loop."""
    participants = [*plan.discrete, *plan.continuous]
    fixed = {p.instance.name: p.period for p in plan.continuous if p.due < math.inf}
    return {
        "wall_s": wall,
        **({"power": plan.power.account()} if plan.power.entries else {}),
        "loop": record.loop,
        "exchanges": record.exchanges,
        **({"algorithm": coupling.account()} if (coupling := plan.coupling) is not None else {}),
        "roles": {p.instance.name: p.role.value for p in participants},
        "steps": {p.instance.name: p.steps for p in participants},
        **({"fixed_step_s": fixed} if fixed else {}),
        "events": {p.instance.name: p.events for p in participants if p.role is Role.EVENT},
        "solver": {p.instance.name: _counters(p.instance) for p in participants if p.instance is not broken},
    }


def _counters(instance: Instance) -> dict[str, int]:
    """Return the counters of the engine's solver, or of the FMU's if it publishes them and is still able to."""
    published = [name for name in _COUNTERS if f"solver.{name}" in instance.fmu.variables]
    with suppress(CallError):
        return instance.counts or dict(
            zip(published, _whole(instance, [f"solver.{n}" for n in published]), strict=True)
        )
    return {}


def _whole(instance: Instance, names: list[str]) -> list[int]:
    """Return whole numbers, by one call if they are of one type."""
    types = {instance.fmu.fmi_types[name] for name in names}
    if len(types) != 1:
        return [int(instance.get_value(name)) for name in names]
    buffer = array(instance.type_codes[types.pop()], [0] * len(names))
    access = instance.access("Get", names, buffer.buffer_info()[0])
    instance.check(access.function, access.call())
    return [int(value) for value in buffer]

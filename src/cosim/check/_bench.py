"""Runs one interface of an FMU step by step, for the rules: the same few verbs for FMI 2.0, 3.0, CS and ME."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from ctypes import c_double
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.model_description import ModelVariable

from cosim.check._subject import Subject
from cosim.engine.fmu._log import Log, fmi2_callbacks

Value = float | int | bool | bytes
STEPS = 12
"""Steps of a run."""

_KINDS = {(2, "CoSimulation"): FMU2Slave, (2, "ModelExchange"): FMU2Model, (3, "CoSimulation"): FMU3Slave}
_EULER = 1e-3
_ITERATIONS = 100
_MOST_COMPARED = 2000
_UNREADABLE = ("Binary", "Clock")
_REAL = ("Real", "Float32", "Float64")


@dataclass(frozen=True)
class Bench:
    """One interface of an FMU that was unpacked into ``folder``."""

    subject: Subject
    interface: str
    folder: Path

    @property
    def start(self) -> float:
        """When runs begin [s]."""
        return self._experiment("startTime") or 0.0

    @property
    def step(self) -> float:
        """The communication step [s] that the FMU asks for, or a 500th of its experiment, or 10 ms."""
        claimed = getattr(self.subject.interfaces[self.interface], "fixedInternalStepSize", None)
        given = _float(claimed) or self._experiment("stepSize")
        if given:
            return given
        stop = self._experiment("stopTime")
        return (stop - self.start) / 500.0 if stop is not None and stop > self.start else 0.01

    def _experiment(self, name: str) -> float | None:
        return _float(getattr(self.subject.description.defaultExperiment, name, None))

    @property
    def is_cs(self) -> bool:
        """Whether the FMU solves itself."""
        return self.interface == "CoSimulation"

    def claims(self, capability: str) -> bool:
        """Tell whether this interface claims a capability."""
        return self.subject.claims(self.interface, capability)

    def reals(self, causality: str) -> list[ModelVariable]:
        """Return the continuous scalars of a causality that are Float64 or Real."""
        return [
            variable
            for variable in self.subject.variables
            if variable.causality == causality
            and variable.type in ("Real", "Float64")
            and variable.variability == "continuous"
            and not variable.shape
        ]

    @property
    def compared(self) -> list[ModelVariable]:
        """The variables that are read in runs: outputs first, then the others, up to a number."""
        known = [v for v in self.subject.variables if v.type not in _UNREADABLE and v.causality != "independent"]
        known.sort(key=lambda variable: variable.causality != "output")
        return known[:_MOST_COMPARED]

    def instance(self, *, event_mode: bool = False, token: str | None = None) -> Instance:
        """Return a new instance; raises Exception if the FMU refuses."""
        return Instance(self, event_mode=event_mode, token=token)


class Instance:
    """An instance; all its methods raise FMICallException if the FMU returns Discard or worse."""

    def __init__(self, bench: Bench, *, event_mode: bool, token: str | None) -> None:
        """Load the library and instantiate."""
        self.bench = bench
        self.log = Log()
        self.event_mode = event_mode
        self.next_event = math.inf
        subject = bench.subject
        kind = _KINDS.get((subject.fmi, bench.interface), FMU3Model)
        self._fmu: Any = kind(
            guid=subject.description.guid if token is None else token,
            modelIdentifier=subject.interfaces[bench.interface].modelIdentifier,
            unzipDirectory=str(bench.folder),
            instanceName="checked",
        )
        log = self.log
        if subject.fmi == 2:
            self._fmu.instantiate(callbacks=fmi2_callbacks(log), loggingOn=False)
        else:
            mode = {"eventModeUsed": event_mode} if bench.is_cs else {}
            self._fmu.instantiate(logMessage=lambda _, status, category, message: log.add(status, message), **mode)

    def __enter__(self) -> Self:
        """Return the instance itself."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        """Free the instance; what it said goes with an error."""
        if error is not None and str(self.log) not in str(error):
            error.add_note(str(self.log))
        getattr(self._fmu, f"fmi{self.bench.subject.fmi}FreeInstance")(self._fmu.component)

    def initialize(self, inside: Callable[[], None] | None = None) -> None:
        """Initialise at the start time, calling ``inside`` in Initialization Mode; then get ready for steps."""
        self.enter_initialization()
        if inside is not None:
            inside()
        self.exit_initialization()

    def enter_initialization(self) -> None:
        """Enter Initialization Mode."""
        if self.bench.subject.fmi == 2:
            self._fmu.setupExperiment(tolerance=1e-6, startTime=self.bench.start)
            self._fmu.enterInitializationMode()
        else:
            self._fmu.enterInitializationMode(tolerance=1e-6, startTime=self.bench.start)

    def exit_initialization(self) -> None:
        """Leave it, and handle the first events, for Step Mode or Continuous-Time Mode."""
        self._fmu.exitInitializationMode()
        if not self.bench.is_cs:
            self.events(enter=False)
            self._fmu.enterContinuousTimeMode()
        elif self.event_mode:
            self.events(enter=False)
            self._fmu.enterStepMode()

    def events(self, *, enter: bool) -> None:
        """Update discrete states until there are no more; raises RuntimeError if that does not end."""
        if enter:
            self._fmu.enterEventMode()
        update = self._fmu.newDiscreteStates if self.bench.subject.fmi == 2 else self._fmu.updateDiscreteStates
        for _ in range(_ITERATIONS):
            again, _, _, _, is_defined, next_event = update()
            if not again:
                self.next_event = next_event if is_defined else math.inf
                return
        raise RuntimeError(f"asks for one more update of its discrete states, {_ITERATIONS} times")

    def run(self, steps: int = STEPS, first: int = 0) -> list[dict[str, list[Value]]]:
        """Step and return the values after each step; ``first`` is the number of steps taken before."""
        rows = []
        for k in range(first, first + steps):
            h = self.bench.step
            self.advance(self.bench.start + k * h, h)
            rows.append(self.values(self.bench.compared))
        return rows

    def advance(self, t: float, h: float) -> None:
        """Step from t over h [s]; Model Exchange takes short steps of Euler's, as a rule looks at functions only."""
        if self.bench.is_cs:
            self._do_step(t, h)
            return
        x, dx = self.states(), self.derivatives()
        start = self.bench.start
        t, h = start + (t - start) * _EULER, h * _EULER
        self._fmu.setTime(t + h)
        self.set_states([value + h * slope for value, slope in zip(x, dx, strict=True)])
        self._fmu.completedIntegratorStep()
        self.events(enter=True)
        self._fmu.enterContinuousTimeMode()

    def _do_step(self, t: float, h: float) -> None:
        if self.bench.subject.fmi == 2:
            self._fmu.doStep(currentCommunicationPoint=t, communicationStepSize=h)
            return
        _, _, early, reached = self._fmu.doStep(currentCommunicationPoint=t, communicationStepSize=h)
        if early:
            raise RuntimeError(f"returned early from a step to {t + h:g} s, at {reached:g} s, which was not allowed")
        if self.event_mode:
            self.events(enter=True)
            self._fmu.enterStepMode()

    def values(self, variables: Iterable[ModelVariable]) -> dict[str, list[Value]]:
        """Return the values of variables by name; scalars of one type are read in one call."""
        found: dict[str, list[Value]] = {}
        by_type: dict[str, list[ModelVariable]] = {}
        for variable in variables:
            if variable.shape:
                count = math.prod(variable.shape)
                found[variable.name] = list(self._getter(variable.type)([variable.valueReference], count))
            else:
                by_type.setdefault(variable.type, []).append(variable)
        for kind, scalars in by_type.items():
            read = self._getter(kind)([variable.valueReference for variable in scalars])
            found.update((variable.name, [value]) for variable, value in zip(scalars, read, strict=True))
        return found

    def _getter(self, kind: str) -> Callable[..., Sequence[Value]]:
        getter: Callable[..., Sequence[Value]] = getattr(self._fmu, f"get{self._accessed(kind)}")
        return getter

    def _accessed(self, kind: str) -> str:
        if kind == "Enumeration":
            return "Integer" if self.bench.subject.fmi == 2 else "Int64"
        return kind

    def set(self, variable: ModelVariable, value: Value) -> None:
        """Set a scalar."""
        getattr(self._fmu, f"set{self._accessed(variable.type)}")([variable.valueReference], [value])

    def reals(self, variables: Sequence[ModelVariable]) -> list[float]:
        """Return the values of Real or Float64 scalars."""
        read = self._getter(variables[0].type) if variables else (lambda _: [])
        return [float(value) for value in read([variable.valueReference for variable in variables])]

    def states(self) -> list[float]:
        """Return the continuous states."""
        return self._vector("getContinuousStates", self.bench.subject.description.numberOfContinuousStates)

    def derivatives(self) -> list[float]:
        """Return their derivatives."""
        name = "getDerivatives" if self.bench.subject.fmi == 2 else "getContinuousStateDerivatives"
        return self._vector(name, self.bench.subject.description.numberOfContinuousStates)

    def nominals(self) -> list[float]:
        """Return their nominal values."""
        return self._vector("getNominalsOfContinuousStates", self.bench.subject.description.numberOfContinuousStates)

    def indicators(self) -> list[float]:
        """Return the event indicators."""
        return self._vector("getEventIndicators", int(self.bench.subject.description.numberOfEventIndicators or 0))

    def counts(self) -> tuple[int, int]:
        """Return the numbers of continuous states and event indicators that an FMI 3.0 Model Exchange FMU tells."""
        return int(self._fmu.getNumberOfContinuousStates()), int(self._fmu.getNumberOfEventIndicators())

    def set_states(self, x: Sequence[float]) -> None:
        """Set the continuous states."""
        self._fmu.setContinuousStates((c_double * len(x))(*x), len(x))

    def _vector(self, function: str, length: int) -> list[float]:
        values = (c_double * length)()
        getattr(self._fmu, function)(values, length)
        return list(values)

    def directional(self, unknowns: Sequence[int], known: int) -> list[float]:
        """Return the derivatives of unknowns by one known, given by value references."""
        return [float(value) for value in self._fmu.getDirectionalDerivative(list(unknowns), [known], [1.0])]

    def adjoint(self, unknown: int, knowns: Sequence[int]) -> list[float]:
        """Return the derivatives of one unknown by knowns, from the adjoint."""
        values = self._fmu.getAdjointDerivative([unknown], list(knowns), [1.0], nSensitivity=len(knowns))
        return [float(value) for value in values]

    def output_derivatives(self, outputs: Sequence[ModelVariable]) -> list[float]:
        """Return the first derivatives of outputs by time, in Co-Simulation."""
        references = [variable.valueReference for variable in outputs]
        get = self._fmu.getRealOutputDerivatives if self.bench.subject.fmi == 2 else self._fmu.getOutputDerivatives
        return [float(value) for value in get(references, [1] * len(references))]

    def set_input_derivatives(self, inputs: Sequence[ModelVariable]) -> None:
        """Let inputs keep their values, by derivatives of 0, in FMI 2.0 Co-Simulation."""
        references = [variable.valueReference for variable in inputs]
        self._fmu.setRealInputDerivatives(references, [1] * len(references), [0.0] * len(references))

    def state(self) -> Any:  # noqa: ANN401 - the FMU's own pointer
        """Return a copy of the whole state, to be given to ``restore`` and ``forget``."""
        return self._fmu.getFMUState()

    def restore(self, state: Any) -> None:  # noqa: ANN401
        """Go back to a state."""
        self._fmu.setFMUState(state)

    def forget(self, state: Any) -> None:  # noqa: ANN401
        """Free a state."""
        self._fmu.freeFMUState(state)

    def serialized(self, state: Any) -> bytes:  # noqa: ANN401
        """Return a state as bytes."""
        return bytes(self._fmu.serializeFMUState(state))

    def deserialized(self, content: bytes) -> Any:  # noqa: ANN401
        """Return a state from bytes."""
        return self._fmu.deserializeFMUState(content)

    def terminate(self) -> None:
        """End the simulation."""
        self._fmu.terminate()

    def reset(self) -> None:
        """Go back to what the instance was before initialisation."""
        self._fmu.reset()

    def version(self) -> str:
        """Return the version of FMI that the binary tells."""
        return str(self._fmu.getVersion())


def is_real(variable: ModelVariable) -> bool:
    """Tell whether a variable is of a floating-point type."""
    return variable.type in _REAL


def _float(text: object) -> float | None:
    try:
        number = float(str(text))
    except ValueError:
        return None
    return number if math.isfinite(number) else None

"""Model Exchange as FMI 2.0 and FMI 3.0 have it: what differs between their calls."""

from __future__ import annotations

from ctypes import addressof, byref, c_bool, c_int, c_void_p

from fmpy.fmi2 import fmi2EventInfo

from cosim.engine.exchange._exchange import ExchangeInstance, Stepper
from cosim.engine.exchange._exchange_native import NativeStepper
from cosim.engine.exchange._exchange_python import PythonStepper
from cosim.engine.fmu._instance import Fmi2Instance, Fmi3Instance
from cosim.engine.native._library import native_library


def _stepper(instance: ExchangeInstance) -> Stepper:
    library = native_library()
    return PythonStepper(instance) if library is None else NativeStepper(instance, library)


class Fmi2Exchange(ExchangeInstance, Fmi2Instance):
    """Model Exchange in FMI 2.0."""

    _enter_initialization = Fmi2Instance.enter_initialization
    _make_stepper = _stepper
    names = ("GetDerivatives", "NewDiscreteStates")

    def _instantiate(self, event_mode: bool, logging: bool) -> None:
        Fmi2Instance._instantiate(self, event_mode, logging)

    def _bind_own(self) -> None:
        self._info = fmi2EventInfo()
        self.step_events = (c_int(), c_int())
        self._new_states = self.bind("NewDiscreteStates", byref(self._info))
        self.complete = self.bind("CompletedIntegratorStep", c_int(1), *map(byref, self.step_events))

    def measure(self) -> tuple[int, int]:
        """Return what the model description says."""
        return self.fmu.n_states_and_indicators

    def update_discrete_states(self) -> int:
        """Call fmi2NewDiscreteStates."""
        status = self._new_states()
        info = self._info
        flags = (
            info.newDiscreteStatesNeeded,
            info.terminateSimulation,
            info.nominalsOfContinuousStatesChanged,
            info.valuesOfContinuousStatesChanged,
            info.nextEventTimeDefined,
        )
        self.update_flags.value = sum(bool(flag) << (8 * byte) for byte, flag in enumerate(flags))
        self.next_event.value = info.nextEventTime
        return status


class Fmi3Exchange(ExchangeInstance, Fmi3Instance):
    """Model Exchange in FMI 3.0."""

    _enter_initialization = Fmi3Instance.enter_initialization
    _make_stepper = _stepper
    names = ("GetContinuousStateDerivatives", "UpdateDiscreteStates")

    def _instantiate(self, event_mode: bool, logging: bool) -> None:
        log = self.log
        self._slave.instantiate(
            loggingOn=logging,
            logMessage=lambda environment, status, category, message: log.add(status, message),
        )

    def _bind_own(self) -> None:
        self.step_events = (c_bool(), c_bool())
        updates = [c_void_p(addressof(self.update_flags) + byte) for byte in range(5)]
        next_event = c_void_p(addressof(self.next_event))
        self._new_states = self.bind("UpdateDiscreteStates", *updates, next_event)
        self.complete = self.bind("CompletedIntegratorStep", c_bool(True), *map(byref, self.step_events))

    def measure(self) -> tuple[int, int]:
        """Ask the FMU."""
        return self._slave.getNumberOfContinuousStates(), self._slave.getNumberOfEventIndicators()

    def update_discrete_states(self) -> int:
        """Call fmi3UpdateDiscreteStates."""
        return self._new_states()

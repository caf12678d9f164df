"""An instantiated FMI 1.0 Co-Simulation FMU."""

from __future__ import annotations

from contextlib import suppress
from ctypes import c_int
from functools import partial
from typing import ClassVar

from fmpy.fmi1 import FMICallException

from cosim.engine.fmu._instance import Instance
from cosim.engine.fmu._log import fmi1_callbacks


class Fmi1Instance(Instance):
    """An FMI 1.0 instance: it has no Initialization Mode, but is initialised by one call, its inputs set before."""

    enumeration_type = "Integer"
    tells_size = False
    initializes_at_once = True
    type_codes: ClassVar[dict[str, str]] = {"Real": "d", "Integer": "i", "Boolean": "b", "Enumeration": "i"}

    def _instantiate(self, event_mode: bool, logging: bool) -> None:
        self._slave.instantiate(functions=fmi1_callbacks(), loggingOn=logging)
        if not self._slave.component:
            raise RuntimeError("no instance")
        self.log.belongs_to(self._slave.component)

    def _bind_calls(self) -> None:
        self.do_step = self._bind(self.symbol("DoStep"), self.t, self.h, c_int(1))

    def symbol(self, function: str) -> str:
        """Return the name of a function in the library, which begins with the model's."""
        return f"{self.fmu.model_identifier}_fmi{function}"

    def set_opaque(self, fmi_type: str, reference: int, values: list[str]) -> None:
        """Call fmiSetString."""
        self._slave.setString([reference], values)

    def enter_initialization(self, tolerance: float, stop: float | None) -> None:
        """Call fmiInitializeSlave, to which no tolerance can be told."""
        self.once("InitializeSlave", partial(self._slave.initialize, 0.0, stop))

    def exit_initialization(self) -> None:
        """Do nothing: the FMU is ready to step."""

    def free(self) -> None:
        """Terminate and free the instance, unless the FMU has declared itself broken."""
        if self._fatal or not self._slave.component:
            return
        self.site.enter("Terminate")
        with suppress(FMICallException):
            self._slave.terminate()
        self.site.enter("FreeInstance")
        self._slave.fmi1FreeSlaveInstance(self._slave.component)
        self.site.leave()
        self._slave.component = None

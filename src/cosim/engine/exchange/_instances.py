"""Which kind of instance an FMU becomes: by its type of interface and its FMI version."""

from __future__ import annotations

from cosim.engine.exchange._exchange_versions import Fmi2Exchange, Fmi3Exchange
from cosim.engine.fmu._calls import Site
from cosim.engine.fmu._fmu import Fmu
from cosim.engine.fmu._instance import Fmi2Instance, Fmi3Instance, Instance
from cosim.engine.fmu._slave1 import Fmi1Instance


def instantiate(name: str, fmu: Fmu, event_mode: bool, site: Site | None = None) -> Instance:
    """Return a new instance of an FMU, whose calls are noted at ``site``; raises FmuError if the FMU refuses."""
    if fmu.interface == "ModelExchange":
        return (Fmi2Exchange if fmu.fmi_version == "2.0" else Fmi3Exchange)(name, fmu, event_mode, site)
    if fmu.fmi_version == "1.0":
        return Fmi1Instance(name, fmu, event_mode, site)
    return (Fmi2Instance if fmu.fmi_version == "2.0" else Fmi3Instance)(name, fmu, event_mode, site)

"""System structures (SSP 1.0 and 2.0) to and from the engine's systems."""

from cosim.ssp._documents import VERSIONS, connector_names
from cosim.ssp._flatten import Input, Tap, same
from cosim.ssp._import import Imported, read_ssp, start_values
from cosim.ssp._write import write_ssp

__all__ = ["VERSIONS", "Imported", "Input", "Tap", "connector_names", "read_ssp", "same", "start_values", "write_ssp"]

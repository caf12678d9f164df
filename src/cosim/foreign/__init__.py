"""Reads the model descriptions that other tools write, also those that break the schema where it does no harm."""

from cosim.foreign._read import RUN_CHECK, Reading, read_description

__all__ = ["RUN_CHECK", "Reading", "read_description"]

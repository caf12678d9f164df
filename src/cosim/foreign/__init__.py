"""Reads the model descriptions that other tools write, also those that break the schema where it does no harm."""

from cosim.foreign._mend import Amiss
from cosim.foreign._read import NAME, RUN_CHECK, Reading, read_description
from cosim.foreign._schema import Violation, violations

__all__ = ["NAME", "RUN_CHECK", "Amiss", "Reading", "Violation", "read_description", "violations"]

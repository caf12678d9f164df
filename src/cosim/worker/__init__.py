"""A process that does one job for this one, in memory that both see, and may die of it: no other part is touched.

It protects from faults, not from malice: what runs there has the user's rights.
"""

from cosim.worker._child import Answer
from cosim.worker._death import Death
from cosim.worker._memory import machine_memory
from cosim.worker._process import Worker, dismiss, prestart

__all__ = ["Answer", "Death", "Worker", "dismiss", "machine_memory", "prestart"]

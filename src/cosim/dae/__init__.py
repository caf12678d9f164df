"""From a flat model to an index-1 DAE with few unknowns, symbolic in CasADi.

The way of the data: ``lower`` (equations as CasADi expressions, events as relations), ``alias`` (trivial equations go),
``index_reduction`` and ``state_selection`` (differentiate constraints, choose states), ``blocks`` and ``tearing``
(what is computed from what, in which order), ``assemble`` (the :class:`Dae`).
"""

from cosim.dae.assemble import compile_dae
from cosim.dae.dae import Dae
from cosim.dae.explanation import explain

__all__ = ["Dae", "compile_dae", "explain"]

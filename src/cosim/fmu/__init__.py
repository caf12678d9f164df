"""FMUs: from a Dae to C, a description and a shared library in one file, and the catalogue of those that come along."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cosim.fmu.exporter import compile_model as compile_model
    from cosim.fmu.exporter import export as export
    from cosim.fmu.exporter import export_all as export_all
    from cosim.fmu.exporter import pack_all as pack_all

__all__ = ["compile_model", "export", "export_all", "pack_all"]


def __getattr__(name: str) -> object:
    """Load the compiler only when it is used: a run with built FMUs needs neither CasADi nor SciPy."""
    if name in __all__:
        import importlib

        return getattr(importlib.import_module("cosim.fmu.exporter"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

"""The command line: ``cosim run``, ``build``, ``info`` and ``export``."""

from cosim.cli._app import main

__all__ = ["main"]

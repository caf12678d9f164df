"""Reproduces figures and tables of the source (P. Fjellander, KTH 2018) from simulations."""

from cosim.thesis._reproduce import Reproduction, reproduce

__all__ = ["Reproduction", "reproduce"]

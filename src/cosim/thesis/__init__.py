"""Reproduces figures and tables of the source (P. Fjellander, KTH 2018) from simulations."""

from cosim.thesis._reproduce import Reproduction, reproduce
from cosim.thesis._same_rate import Pair, same_rate
from cosim.thesis._sensitivity_report import Sensitivity, sensitivity

__all__ = ["Pair", "Reproduction", "Sensitivity", "reproduce", "same_rate", "sensitivity"]

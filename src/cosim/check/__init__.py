"""Judges an FMU by rules: its archive, its XML, its binaries, and how it behaves when it is run, in a process apart."""

from cosim.check._about import About, Description, describe
from cosim.check._check import Report, check, rules
from cosim.check._rules import Finding, Severity

__all__ = ["About", "Description", "Finding", "Report", "Severity", "check", "describe", "rules"]

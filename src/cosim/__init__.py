"""Acausal Modelica models as portable FMUs, and co-simulation of FMUs of any origin."""

__version__ = "0.1.0"

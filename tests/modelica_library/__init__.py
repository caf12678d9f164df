"""Tests of modelica/WiperDrive through the front end alone."""

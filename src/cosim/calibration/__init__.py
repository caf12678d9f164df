"""Fits parameters of the drive to measurements."""

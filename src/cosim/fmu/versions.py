"""The FMI versions that FMUs are written for, and the names of their files."""

from __future__ import annotations

from typing import Literal

FmiVersion = Literal["2.0", "3.0"]
FmiChoice = Literal["2.0", "3.0", "both"]


def versions_of(choice: FmiChoice) -> tuple[FmiVersion, ...]:
    """The versions that a choice stands for."""
    return ("3.0", "2.0") if choice == "both" else (choice,)


def file_name(name: str, fmi: FmiVersion) -> str:
    """The name of an FMU's file: that of FMI 3.0 needs no mark."""
    return f"{name}.fmu" if fmi == "3.0" else f"{name}.fmi2.fmu"

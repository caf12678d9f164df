"""Rules on the binaries of all platforms, none of which is run here."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from functools import lru_cache
from typing import Any

from cosim.check._rules import Found, Rules, Severity, shortened
from cosim.check._subject import Subject
from cosim.fmu.toolchain import fmi_functions

BINARY_RULES: Rules[Subject] = Rules()

_SUFFIXES = {"win": ".dll", "windows": ".dll", "linux": ".so", "darwin": ".dylib"}
_FORMATS = {".dll": "PE", ".so": "ELF", ".dylib": "MachO"}
_PROCESSORS = {
    "x86_64": ("AMD64", "X86_64"),
    "x86": ("I386", "X86"),
    "aarch64": ("ARM64", "AARCH64"),
    "aarch32": ("ARM", "ARMNT", "THUMB"),
    "riscv64": ("RISCV", "RISCV64"),
}
_FMI2_FOLDERS = ("win32", "win64", "linux32", "linux64", "darwin64")
_ONLY_ME = (
    "EnterContinuousTimeMode",
    "CompletedIntegratorStep",
    "SetTime",
    "SetContinuousStates",
    "GetDerivatives",
    "GetContinuousStateDerivatives",
    "GetEventIndicators",
    "GetContinuousStates",
    "GetNominalsOfContinuousStates",
    "GetNumberOfEventIndicators",
    "GetNumberOfContinuousStates",
    "InstantiateModelExchange",
)
_ONLY_CS = (
    "SetRealInputDerivatives",
    "GetRealOutputDerivatives",
    "DoStep",
    "CancelStep",
    "GetStatus",
    "GetRealStatus",
    "GetIntegerStatus",
    "GetBooleanStatus",
    "GetStringStatus",
    "EnterStepMode",
    "GetOutputDerivatives",
    "InstantiateCoSimulation",
)
_ONLY_SE = ("ActivateModelPartition", "InstantiateScheduledExecution")
_ME_IN_FMI2 = ("EnterEventMode", "NewDiscreteStates")
_EXPORT = "export the model again, or tell whoever exported it"


def functions_for(fmi: int, interfaces: set[str]) -> list[str]:
    """Return the functions that a library has to export for these interfaces."""
    others = {"ModelExchange": _ONLY_ME, "CoSimulation": _ONLY_CS, "ScheduledExecution": _ONLY_SE}
    needless = {name for interface, names in others.items() if interface not in interfaces for name in names}
    if fmi == 2 and "ModelExchange" not in interfaces:
        needless.update(_ME_IN_FMI2)
    names = fmi_functions("2.0" if fmi == 2 else "3.0")
    return [name for name in names if name.removeprefix(f"fmi{fmi}") not in needless]


def _system(folder: str) -> str:
    return folder.rpartition("-")[2] if "-" in folder else folder.rstrip("0123456789")


def _suffix(folder: str) -> str:
    return _SUFFIXES.get(_system(folder), ".so")


def _has(files: list[str], file: str) -> bool:
    """Tell whether a file is there; Windows makes no difference between capital and small letters."""
    return file in files or (file.endswith(".dll") and file.lower() in [name.lower() for name in files])


def _libraries(subject: Subject) -> Iterator[tuple[str, str, set[str]]]:
    """Yield each library that is there: folder, file, and the interfaces that need it."""
    needed: dict[str, set[str]] = {}
    for name, interface in subject.interfaces.items():
        needed.setdefault(interface.modelIdentifier, set()).add(name)
    for folder, files in subject.folders.items():
        for identifier, names in needed.items():
            file = f"{identifier}{_suffix(folder)}"
            if file in files:
                yield folder, file, names


@lru_cache(maxsize=8)
def _parsed(content: bytes) -> Any:  # noqa: ANN401 - a lief.Binary of one of three formats, or None
    import lief

    lief.logging.disable()  # it speaks of parts that no FMU needs
    return lief.parse(content)


def _binary(subject: Subject, folder: str, file: str) -> Any:  # noqa: ANN401
    return _parsed(subject.archive.read(f"binaries/{folder}/{file}"))


def _can_look() -> bool:
    return importlib.util.find_spec("lief") is not None


@BINARY_RULES("binary.none", Severity.ERROR)
def none(subject: Subject) -> Iterator[Found]:
    """There is a binary or there are sources for it."""
    if not any(subject.folders.values()) and not any(name.startswith("sources/") for name in subject.archive.sizes):
        yield Found("has neither binaries nor sources", "binaries", _EXPORT)


@BINARY_RULES("binary.missing", Severity.ERROR)
def missing(subject: Subject) -> Iterator[Found]:
    """In each platform's folder there is the library of each modelIdentifier, with the ending of that platform."""
    for folder, files in subject.folders.items():
        for identifier in {interface.modelIdentifier for interface in subject.interfaces.values()}:
            file = f"{identifier}{_suffix(folder)}"
            if not _has(files, file):
                yield Found(f"{file} is missing", f"binaries/{folder}", _EXPORT)


@BINARY_RULES("binary.folder", Severity.WARNING)
def folder_name(subject: Subject) -> Iterator[Found]:
    """Folders are named as FMI names platforms: win64, linux64, darwin64, ... in 2.0, x86_64-windows, ... in 3.0."""
    for folder in subject.folders:
        parts = folder.split("-")
        is_new = len(parts) >= 2 and parts[0] in _PROCESSORS and parts[1] in _SUFFIXES and parts[1] != "win"
        if subject.fmi == 2 and folder not in _FMI2_FOLDERS and not is_new:
            yield Found("is no platform of FMI 2.0", f"binaries/{folder}", f"there are {', '.join(_FMI2_FOLDERS)}")
        if subject.fmi == 3 and not is_new:
            yield Found("is no platform of FMI 3.0", f"binaries/{folder}", "write processor-system: x86_64-linux")


@BINARY_RULES("binary.format", Severity.ERROR)
def binary_format(subject: Subject) -> Iterator[Found]:
    """Each library has the format and the processor of the platform in whose folder it lies."""
    if not _can_look():
        return
    for folder, file, _ in _libraries(subject):
        where = f"binaries/{folder}/{file}"
        parsed = _binary(subject, folder, file)
        if parsed is None:
            yield Found("is no library of a known format", where, _EXPORT)
            continue
        found = str(parsed.format).rpartition(".")[2].upper()
        expected = _FORMATS[_suffix(folder)].upper()
        if found != expected:
            yield Found(f"is a file of format {found}, but {expected} is expected", where, _EXPORT)
            continue
        processor = _processor(parsed)
        wanted = _PROCESSORS.get(folder.partition("-")[0]) if "-" in folder else None
        if wanted is not None and processor not in wanted:
            yield Found(f"is for the processor {processor}", where, "put it into the folder of its processor")


def _processor(parsed: Any) -> str:  # noqa: ANN401
    header = parsed.header
    for name in ("machine_type", "machine", "cpu_type"):
        if hasattr(header, name):
            return str(getattr(header, name)).rpartition(".")[2].upper()
    return "unknown"


def _exported(parsed: Any) -> set[str]:  # noqa: ANN401
    if hasattr(parsed, "get_export"):
        table = parsed.get_export()
        return {str(entry.name) for entry in table.entries} if table else set()
    names = {str(symbol.name) for symbol in parsed.exported_symbols}
    return names | {name.removeprefix("_") for name in names}


@BINARY_RULES("binary.exports", Severity.ERROR)
def exports(subject: Subject) -> Iterator[Found]:
    """Each library exports all functions that the claimed interfaces have in the standard's header."""
    if not _can_look() or subject.fmi == 1:
        return
    for folder, file, interfaces in _libraries(subject):
        parsed = _binary(subject, folder, file)
        if parsed is None or (not hasattr(parsed, "exported_symbols") and not hasattr(parsed, "get_export")):
            continue
        found = _exported(parsed)
        if absent := [name for name in functions_for(subject.fmi, interfaces) if name not in found]:
            yield Found(f"does not export {shortened(absent)}", f"binaries/{folder}/{file}", _EXPORT)


@BINARY_RULES("binary.unseen", Severity.NOTE)
def unseen(subject: Subject) -> Iterator[Found]:
    """Binaries can be looked into, which takes the package lief."""
    if subject.folders and not _can_look():
        yield Found("were not looked into", "binaries", "pip install lief")

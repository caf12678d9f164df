"""An FMU on disk: its description, and its unpacked binary for as long as it is needed."""

from __future__ import annotations

import itertools
import math
import os
import re
import shutil
import tempfile
import threading
import warnings
import weakref
from collections.abc import Iterable
from pathlib import Path
from types import TracebackType
from typing import Literal, Self, TypeAlias

import fmpy
from fmpy.fmi1 import FMU1Slave
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.model_description import InterfaceType, ModelDescription, Unknown

from cosim.archive import Archive
from cosim.engine.fmu._binary import load
from cosim.engine.fmu._fmi1 import facts_of
from cosim.engine.fmu._states import States, states_of
from cosim.engine.fmu._variable import Variable, left_out, names_of, opaque_of, variables_of
from cosim.errors import FmuError, FmuWarning
from cosim.foreign import RUN_CHECK, read_description

_CAPABILITIES = (
    "needsExecutionTool",
    "canBeInstantiatedOnlyOncePerProcess",
    "canGetAndSetFMUstate",
    "canSerializeFMUstate",
    "providesDirectionalDerivative",
    "canHandleVariableCommunicationStepSize",
    "fixedInternalStepSize",
    "maxOutputDerivativeOrder",
    "canInterpolateInputs",
    "providesIntermediateUpdate",
    "canReturnEarlyAfterIntermediateUpdate",
    "hasEventMode",
)

Interface = Literal["CoSimulation", "ModelExchange"]
Library: TypeAlias = FMU1Slave | FMU2Slave | FMU3Slave | FMU2Model | FMU3Model
"""fmpy's objects, each with the functions of its version and interface."""

_KINDS = {
    ("1.0", "CoSimulation"): FMU1Slave,
    ("2.0", "CoSimulation"): FMU2Slave,
    ("3.0", "CoSimulation"): FMU3Slave,
    ("2.0", "ModelExchange"): FMU2Model,
    ("3.0", "ModelExchange"): FMU3Model,
}

# fmpy changes the working folder of the process while it loads a library.
_loading = threading.Lock()


class Fmu:
    """An FMU for Co-Simulation (FMI 1.0, 2.0 or 3.0) or Model Exchange (2.0 or 3.0), unpacked once into a folder.

    ``path`` is the file, ``name`` the model's name, ``fmi_version`` "1.0", "2.0" or "3.0", ``sha256`` the file's hash,
    ``interface`` the one that is used, ``model_identifier`` the name of its binary,
    ``variables`` all scalar variables and elements of arrays by name, ``left_out`` what the others are ("a Clock"),
    ``capabilities`` the attributes of the interface's element and ``platforms``, the folders with binaries.

    ``fmi_types`` holds each variable's type in the FMU ("Float64", "Int32", ...), ``dependencies`` the inputs that each
    output depends on directly, None where the model description does not say, ``initial_dependencies`` the same in
    Initialization Mode.

    Use it as a context manager or call ``close``; otherwise the folder is removed when the object is collected or
    Python ends.
    """

    path: Path
    name: str
    fmi_version: str
    variables: dict[str, Variable]
    sha256: str
    generation_tool: str | None
    has_event_mode: bool
    """Always for Model Exchange."""
    interface: Interface
    model_identifier: str
    needs_completed_step: bool
    """Model Exchange: it is to be told of each step of the solver."""
    fixed_step: float | None
    """Length [s] of the steps that it takes if it takes steps of one length only, where it says so."""
    n_states_and_indicators: tuple[int, int]
    """Model Exchange in FMI 2.0."""
    states: States
    """Model Exchange."""
    capabilities: dict[str, object]
    fmi_types: dict[str, str]
    left_out: dict[str, str]
    dependencies: dict[str, frozenset[str] | None]
    initial_dependencies: dict[str, frozenset[str] | None]
    has_continuous_states: bool
    state_names: tuple[str, ...]
    """Those continuous states that the model description names: numbers that can be read at any time."""
    log_categories: tuple[str, ...]

    def __init__(
        self,
        path: Path,
        description: ModelDescription,
        xml: bytes,
        sha256: str,
        platforms: tuple[str, ...],
        interface: Interface,
    ) -> None:
        """Take over what ``read`` has found; users call ``read``."""
        self.path = path
        self.name = description.modelName
        self.fmi_version = f"{description.fmiMajorVersion}.0"
        element = _element(description, interface)
        self.interface = interface
        self.model_identifier = element.modelIdentifier
        self.sha256 = sha256
        self.generation_tool = description.generationTool
        exchange = interface == "ModelExchange"
        self.has_event_mode = exchange or bool(element.hasEventMode)
        self.needs_completed_step = exchange and bool(element.needsCompletedIntegratorStep)
        self.n_states_and_indicators = (len(description.derivatives), description.numberOfEventIndicators or 0)
        self.states = states_of(description) if exchange else States()
        self.capabilities = {key: getattr(element, key, None) for key in _CAPABILITIES}
        if self.fmi_version == "3.0":
            self.capabilities["providesDirectionalDerivative"] = _provides_derivatives(xml, interface)
        facts = facts_of(xml) if self.fmi_version == "1.0" else None
        if facts:
            self.capabilities |= facts.capabilities
        if exchange:
            self.capabilities["canHandleVariableCommunicationStepSize"] = True
        self.capabilities["platforms"] = platforms
        self.fixed_step = None
        if not self.capabilities["canHandleVariableCommunicationStepSize"]:
            self.fixed_step = _fixed_step(description, self.capabilities["fixedInternalStepSize"])
        self.variables = {}
        self.fmi_types = {}
        self.left_out = {}
        opaque = opaque_of(xml)
        for described in description.modelVariables:
            what = left_out(described)
            if facts and described.name in facts.negated:
                what = "the negative of another variable"
            if what is not None:
                self.left_out[described.name] = what
                continue
            for variable in variables_of(described, opaque):
                self.variables[variable.name] = variable
                self.fmi_types[variable.name] = described.type
        self.dependencies = _dependencies(description.outputs)
        exact = [v for v in description.modelVariables if v.causality == "output" and v.initial == "exact"]
        self.initial_dependencies = {name: frozenset() for variable in exact for name in names_of(variable)}
        self.initial_dependencies |= _dependencies(description.initialUnknowns)
        self.has_continuous_states = bool(description.derivatives)
        states = [getattr(unknown.variable, "derivative", None) for unknown in description.derivatives]
        self.state_names = tuple(
            name for state in states if state is not None for name in names_of(state) if name in self.variables
        )
        self.log_categories = tuple(category.name for category in description.logCategories)
        self._token = description.guid
        self._loaded: list[Library] = []
        self._folder = tempfile.mkdtemp(prefix="cosim-")
        self._finalizer = weakref.finalize(self, _release, self._folder, self._loaded)

    @classmethod
    def read(cls, path: Path | str, interface: Interface | None = None) -> Fmu:
        """Read the description of an FMU and unpack it; warns of what is wrong with it without harm (FmuWarning).

        ``interface`` chooses if there are both; by default Co-Simulation is taken where there is one. Raises FmuError
        if the file is missing, is no FMU, is damaged or dangerous to unpack, has no interface that can be used or no
        binary for this computer.
        """
        path = Path(path)
        archive = Archive.open(path)
        description, xml, amiss, _ = read_description(archive)
        for what in amiss:
            warnings.warn(f"{path}: {what}", FmuWarning, stacklevel=2)
        names = archive.sizes
        interface = interface or ("CoSimulation" if description.coSimulation is not None else "ModelExchange")
        if _element(description, interface) is None:
            missing = "Co-Simulation" if interface == "CoSimulation" else "Co-Simulation or Model Exchange"
            raise FmuError(f"has no {missing} interface; export it for Co-Simulation", file=path)
        if description.fmiMajorVersion == 1 and interface == "ModelExchange":
            raise FmuError(
                "is for Model Exchange in FMI 1.0; export it for Co-Simulation, or for FMI 2.0 or 3.0", file=path
            )
        platforms = tuple(sorted({n.split("/")[1] for n in names if n.startswith("binaries/") and n.count("/") > 1}))
        library = _library_path(description, interface)
        if library not in names:
            raise FmuError(
                f"has no binary for this computer ({library}); it has {', '.join(platforms) or 'none'}; "
                f"{_remedy(path, names)}",
                file=path,
            )
        try:
            fmu = cls(path, description, xml, archive.sha256, platforms, interface)
        except (ValueError, OverflowError, TypeError) as error:
            raise FmuError(f"its variables cannot be read: {error}; {RUN_CHECK}", file=path) from error
        wanted = (library.rsplit("/", 1)[0] + "/", "resources/", "modelDescription.xml")
        try:
            archive.extract(fmu._folder, wanted)
        except FmuError:
            fmu.close()
            raise
        return fmu

    def slave(self) -> Library:
        """Return fmpy's object, its library loaded (once for all instances).

        Raises FmuError if the library cannot be loaded or lacks a function.
        """
        if not self._finalizer.alive:
            raise FmuError("is closed; read it again to use it", file=self.path)
        with _loading:
            if not self._loaded:
                self._loaded.append(self._load())
        return self._loaded[0]

    def _load(self) -> Library:
        kind = _KINDS[self.fmi_version, self.interface]
        working_folder = Path.cwd()
        try:
            return load(
                kind,
                self.fmi_types.values(),
                self.path,
                guid=self._token,
                modelIdentifier=self.model_identifier,
                unzipDirectory=self._folder,
            )
        finally:
            os.chdir(working_folder)

    def __getstate__(self) -> dict[str, object]:
        """Return what another process needs to use the same folder, which stays this one's to remove."""
        if not self._finalizer.alive:
            raise FmuError("is closed; read it again to use it", file=self.path)
        return {key: value for key, value in vars(self).items() if key not in ("_loaded", "_finalizer")}

    def __setstate__(self, state: dict[str, object]) -> None:
        """Take that over; ``close`` unloads the library."""
        vars(self).update(state)
        self._loaded = []
        self._finalizer = weakref.finalize(self, _release, None, self._loaded)

    def close(self) -> None:
        """Unload the library and remove the temporary folder; no simulation may be using it."""
        self._finalizer()

    def __enter__(self) -> Self:
        """Return the FMU itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the FMU."""
        self.close()


def _release(folder: str | None, loaded: list[Library]) -> None:
    while loaded:
        loaded.pop().freeLibrary()
    if folder is not None:
        shutil.rmtree(folder, ignore_errors=True)


def _fixed_step(description: ModelDescription, internal: object) -> float | None:
    experiment = description.defaultExperiment
    for given in (internal, experiment.stepSize if experiment is not None else None):
        step = float(str(given)) if given is not None else math.nan
        if math.isfinite(step) and step > 0.0:
            return step
    return None


def _remedy(path: Path, names: Iterable[str]) -> str:
    if any(name.startswith("sources/") and name.endswith(".c") for name in names):
        return f"it has C sources: `fmpy compile {path}` adds a binary that a C compiler here makes of them"
    return "export it for this platform"


def _dependencies(unknowns: Iterable[Unknown]) -> dict[str, frozenset[str] | None]:
    return {
        name: None
        if unknown.dependencies is None
        else frozenset(itertools.chain.from_iterable(map(names_of, unknown.dependencies)))
        for unknown in unknowns
        for name in names_of(unknown.variable)
    }


def _provides_derivatives(xml: bytes, interface: Interface) -> bool:
    """Tell whether an FMI 3.0 FMU provides directional derivatives; fmpy looks for the attribute of FMI 2.0."""
    element = re.search(rb"<%b\s[^>]*>" % interface.encode(), xml)
    claim = rb"\sprovidesDirectionalDerivatives\s*=\s*[\"'](true|1)[\"']"
    return element is not None and re.search(claim, element[0]) is not None


def _element(description: ModelDescription, interface: Interface) -> InterfaceType:
    return description.coSimulation if interface == "CoSimulation" else description.modelExchange


def _library_path(description: ModelDescription, interface: Interface) -> str:
    folder = fmpy.platform_tuple if description.fmiMajorVersion == 3 else fmpy.platform
    return f"binaries/{folder}/{_element(description, interface).modelIdentifier}{fmpy.sharedLibraryExtension}"

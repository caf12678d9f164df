"""An FMU on disk: its description, and its unpacked binary for as long as it is needed."""

from __future__ import annotations

import itertools
import os
import shutil
import tempfile
import threading
import warnings
import weakref
from pathlib import Path
from types import TracebackType
from typing import Self

import fmpy
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.model_description import ModelDescription

from cosim.archive import Archive
from cosim.engine._variable import Variable, left_out, names_of, opaque_of, variables_of
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

# fmpy changes the working folder of the process while it loads a library.
_loading = threading.Lock()


class Fmu:
    """A Co-Simulation FMU (FMI 2.0 or 3.0), unpacked once into a temporary folder.

    ``path`` is the file, ``name`` the model's name, ``fmi_version`` "2.0" or "3.0", ``sha256`` the file's hash,
    ``variables`` all scalar variables and elements of arrays by name, ``left_out`` what the others are ("a Clock"),
    ``capabilities`` the attributes of the CoSimulation element and ``platforms``, the folders with binaries.

    ``fmi_types`` holds each variable's type in the FMU ("Float64", "Int32", ...), ``dependencies`` the inputs that each
    output depends on directly, None where the model description does not say.

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
    capabilities: dict[str, object]
    fmi_types: dict[str, str]
    left_out: dict[str, str]
    dependencies: dict[str, frozenset[str] | None]
    has_continuous_states: bool
    log_categories: tuple[str, ...]

    def __init__(
        self, path: Path, description: ModelDescription, xml: bytes, sha256: str, platforms: tuple[str, ...]
    ) -> None:
        """Take over what ``read`` has found; users call ``read``."""
        self.path = path
        self.name = description.modelName
        self.fmi_version = "2.0" if description.fmiMajorVersion == 2 else "3.0"
        self.sha256 = sha256
        self.generation_tool = description.generationTool
        self.has_event_mode = bool(description.coSimulation.hasEventMode)
        self.capabilities = {key: getattr(description.coSimulation, key) for key in _CAPABILITIES}
        self.capabilities["platforms"] = platforms
        self.variables = {}
        self.fmi_types = {}
        self.left_out = {}
        opaque = opaque_of(xml)
        for described in description.modelVariables:
            what = left_out(described)
            if what is not None:
                self.left_out[described.name] = what
            for variable in variables_of(described, opaque):
                self.variables[variable.name] = variable
                self.fmi_types[variable.name] = described.type
        self.dependencies = {
            name: None
            if unknown.dependencies is None
            else frozenset(itertools.chain.from_iterable(map(names_of, unknown.dependencies)))
            for unknown in description.outputs
            for name in names_of(unknown.variable)
        }
        self.has_continuous_states = bool(description.derivatives)
        self.log_categories = tuple(category.name for category in description.logCategories)
        self._description = description
        self._loaded: list[FMU2Slave | FMU3Slave] = []
        self._folder = tempfile.mkdtemp(prefix="cosim-")
        self._finalizer = weakref.finalize(self, _release, self._folder, self._loaded)

    @classmethod
    def read(cls, path: Path | str) -> Fmu:
        """Read the description of an FMU and unpack it; warns of what is wrong with it without harm (FmuWarning).

        Raises FmuError if the file is missing, is no FMU, is damaged or dangerous to unpack, has no Co-Simulation
        interface or no binary for this computer.
        """
        path = Path(path)
        archive = Archive.open(path)
        description, xml, amiss = read_description(archive)
        for what in amiss:
            warnings.warn(f"{path}: {what}", FmuWarning, stacklevel=2)
        names = archive.sizes
        if description.fmiMajorVersion == 1:
            raise FmuError("is an FMI 1.0 FMU; export it for FMI 2.0 or 3.0", file=path)
        if description.coSimulation is None:
            raise FmuError("has no Co-Simulation interface; export it for Co-Simulation", file=path)
        platforms = tuple(sorted({n.split("/")[1] for n in names if n.startswith("binaries/") and n.count("/") > 1}))
        library = _library_path(description)
        if library not in names:
            raise FmuError(
                f"has no binary for this computer ({library}); it has {', '.join(platforms) or 'none'}; "
                "export it for this platform",
                file=path,
            )
        try:
            fmu = cls(path, description, xml, archive.sha256, platforms)
        except (ValueError, OverflowError, TypeError) as error:
            raise FmuError(f"its variables cannot be read: {error}; {RUN_CHECK}", file=path) from error
        wanted = (library.rsplit("/", 1)[0] + "/", "resources/", "modelDescription.xml")
        try:
            archive.extract(fmu._folder, wanted)
        except FmuError:
            fmu.close()
            raise
        return fmu

    def slave(self) -> FMU2Slave | FMU3Slave:
        """Return fmpy's FMU2Slave or FMU3Slave, its library loaded (once for all instances).

        Raises FmuError if the library cannot be loaded or lacks a function.
        """
        if not self._finalizer.alive:
            raise FmuError("is closed; read it again to use it", file=self.path)
        with _loading:
            if not self._loaded:
                self._loaded.append(self._load())
        return self._loaded[0]

    def _load(self) -> FMU2Slave | FMU3Slave:
        kind = FMU2Slave if self.fmi_version == "2.0" else FMU3Slave
        working_folder = Path.cwd()
        try:
            return kind(
                guid=self._description.guid,
                modelIdentifier=self._description.coSimulation.modelIdentifier,
                unzipDirectory=self._folder,
            )
        except AttributeError as error:
            raise FmuError(f"its binary lacks an FMI function: {error}; export it again", file=self.path) from error
        except Exception as error:
            raise FmuError(f"its binary cannot be loaded: {error}", file=self.path) from error
        finally:
            os.chdir(working_folder)

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


def _release(folder: str, loaded: list[FMU2Slave | FMU3Slave]) -> None:
    while loaded:
        loaded.pop().freeLibrary()
    shutil.rmtree(folder, ignore_errors=True)


def _library_path(description: ModelDescription) -> str:
    folder = fmpy.platform if description.fmiMajorVersion == 2 else fmpy.platform_tuple
    return f"binaries/{folder}/{description.coSimulation.modelIdentifier}{fmpy.sharedLibraryExtension}"

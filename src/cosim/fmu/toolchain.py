"""Compiles C to shared libraries for any platform with zig from PyPI, or with the system's cc for this one."""

from __future__ import annotations

import importlib.util
import os
import platform
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from threading import BoundedSemaphore

from cosim.errors import BuildError
from cosim.fmu.versions import FmiVersion

RUNTIME = Path(__file__).parent / "runtime"

# no debug information: it holds the temporary folder's name, so that no two builds would be the same
_COMPILING = ("-std=c11", "-g0", "-ffunction-sections", "-fdata-sections")
# -Os is for what zig adds of its own, such as Windows' start-up code
_LINKING = ("-g0", "-s", "-shared", "-Os")
PORTABLE_FLAGS = ("-O2", "-fPIC", "-fvisibility=hidden", "-ffp-contract=off", "-fno-math-errno")
"""What other compilers are told as well, that build an FMU from its sources: they are to give the same numbers."""


_AT_WORK = BoundedSemaphore(os.cpu_count() or 1)
"""As many compilers at a time as there are processors, however many threads want one."""


@dataclass(frozen=True)
class Platform:
    """A target: its FMI 3 name, its FMI 2 name, zig's name for it, and how its libraries end.

    FMI 2.0 names no processors: importers on ARM look where those on Intel look.
    """

    fmi3: str
    fmi2: str
    zig: str
    suffix: str

    def folder(self, fmi: FmiVersion) -> str:
        """Its folder under ``binaries/`` of an FMU."""
        return self.fmi3 if fmi == "3.0" else self.fmi2


PLATFORMS = {
    "x86_64-linux": Platform("x86_64-linux", "linux64", "x86_64-linux-gnu.2.17", ".so"),
    "aarch64-linux": Platform("aarch64-linux", "linux64", "aarch64-linux-gnu.2.17", ".so"),
    "x86_64-windows": Platform("x86_64-windows", "win64", "x86_64-windows-gnu", ".dll"),
    "x86_64-darwin": Platform("x86_64-darwin", "darwin64", "x86_64-macos.11.0", ".dylib"),
    "aarch64-darwin": Platform("aarch64-darwin", "darwin64", "aarch64-macos.11.0", ".dylib"),
}


def host_name() -> str:
    """The platform this runs on, in the words of PLATFORMS, whether it is one of them or not."""
    machine = platform.machine().lower()
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(machine, machine)
    return f"{machine}-{platform.system().lower()}"


def host() -> Platform:
    """The platform this runs on.

    Raises:
        BuildError: no FMU can be built for it.
    """
    name = host_name()
    if name not in PLATFORMS:
        raise BuildError(f"FMUs can be built for {', '.join(PLATFORMS)}, but this machine is {name}")
    return PLATFORMS[name]


def fmi_headers() -> Path:
    """The folder with fmi2Functions.h and fmi3Functions.h: the one inside the fmpy package."""
    found = importlib.util.find_spec("fmpy")
    if found is None or not found.submodule_search_locations:
        raise BuildError("the FMI headers come with fmpy; install it with: pip install fmpy")
    return Path(found.submodule_search_locations[0]) / "c-code"


def chosen(names: str, fmi: FmiVersion = "3.0") -> tuple[Platform, ...]:
    """The platforms that a choice stands for: "host", "all", or names such as "x86_64-linux,x86_64-windows".

    FMI 2.0 names no processors, so its "all" are those on x86_64, and two of one system cannot be in one FMU.

    Raises:
        BuildError: there is no such platform, or two that do not go together.
    """
    if names == "host":
        return (host(),)
    wanted = [p for p in PLATFORMS if fmi == "3.0" or p.startswith("x86_64")] if names == "all" else names.split(",")
    unknown = [name for name in wanted if name.strip() not in PLATFORMS]
    if unknown:
        name = unknown[0].strip()
        if name in ("host", "all"):
            raise BuildError(f"'{name}' stands alone; give it without others, or a list of {', '.join(PLATFORMS)}")
        raise BuildError(f"no platform '{name}'; there are host, all, {', '.join(PLATFORMS)}")
    platforms = [PLATFORMS[name] for name in dict.fromkeys(name.strip() for name in wanted)]
    by_folder: dict[str, list[str]] = {}
    for target in platforms:
        by_folder.setdefault(target.folder(fmi), []).append(target.fmi3)
    for together in by_folder.values():
        if len(together) > 1:
            raise BuildError(
                f"FMI 2.0 names no processors: {' and '.join(together)} do not fit into one FMU; "
                "choose one of them, or FMI 3.0"
            )
    return tuple(platforms)


def compiler(target: Platform | None = None) -> list[str]:
    """The compiler command for a platform (default: this one), without arguments.

    Raises:
        BuildError: there is none.
    """
    target = target or host()
    if importlib.util.find_spec("ziglang") is not None:
        return [sys.executable, "-m", "ziglang", "cc", "-target", target.zig]
    if target == host():
        for name in ("cc", "gcc", "clang"):
            path = shutil.which(name)
            if path:
                return [path]
    raise BuildError(
        f"there is no C compiler for {target.fmi3}; install one from PyPI with: pip install 'wiper-cosim[build]'"
    )


def runtime_sources(fmi: FmiVersion | None) -> list[Path]:
    """The C files of the runtime with the shell of one FMI version, or with none.

    Two shells do not fit into one library.
    """
    common = [file for file in RUNTIME.glob("*.c") if file.name[:3] != "fmi"]
    return sorted([*common, *(shell_sources(fmi) if fmi else [])])


def shell_sources(fmi: FmiVersion) -> list[Path]:
    """The C files of the shell of one FMI version."""
    return sorted(RUNTIME.glob(f"fmi{fmi[0]}*.c"))


def compile_library(
    sources: Sequence[Path],
    includes: Sequence[Path],
    output: Path,
    fmi: FmiVersion = "3.0",
    target: Platform | None = None,
) -> None:
    """Compile and link a shared library for a platform (default: this one).

    Raises:
        BuildError: the compiler is missing or reports an error, or the library does not export the FMI functions.
    """
    target = target or host()
    arguments = [*_COMPILING, *PORTABLE_FLAGS, *(f"-I{folder.resolve()}" for folder in includes)]
    _link([*arguments, *(str(source.resolve()) for source in sources)], output, fmi, target)


def compile_object(source: Path, includes: Sequence[Path], output: Path, target: Platform) -> None:
    """Compile one translation unit for a platform.

    Raises:
        BuildError: the compiler is missing or reports an error.
    """
    folders = [f"-I{folder.resolve()}" for folder in includes]
    # no tables to unwind the stack by, for C throws nothing; Windows needs them
    tables = [] if target.suffix == ".dll" else ["-fno-asynchronous-unwind-tables", "-fno-unwind-tables"]
    _run(
        [*compiler(target), *_COMPILING, *PORTABLE_FLAGS, *tables, *folders, "-c", "-o", output.name, str(source)],
        output,
    )


def link_library(objects: Sequence[Path], output: Path, fmi: FmiVersion, target: Platform) -> None:
    """Link what :func:`compile_object` made to a shared library.

    Raises:
        BuildError: the compiler is missing or reports an error, or the library does not export the FMI functions.
    """
    # by relative paths: libraries for macOS keep a trace of what these are called
    _link([os.path.relpath(path, output.parent) for path in objects], output, fmi, target)


def _link(arguments: Sequence[str], output: Path, fmi: FmiVersion, target: Platform) -> None:
    libraries = [] if target.suffix == ".dll" else ["-lm"]
    command = compiler(target)
    # the linker that comes with macOS has another name for this
    unused = ["-Wl,--gc-sections"] if target.suffix != ".dylib" or "ziglang" in command else []
    _run([*command, *_LINKING, *unused, "-o", output.name, *arguments, *libraries], output)
    found = _exported(output, target)
    missing = [name for name in fmi_functions(fmi) if name not in found]
    if missing:
        raise BuildError(
            f"the compiled library {output.name} for {target.fmi3} does not export {missing[0]}: wrong header macros"
        )


def _run(command: Sequence[str], output: Path) -> None:
    """Run the compiler in the folder of its output, since a library for macOS holds its own name as it was given."""
    # libraries for Windows say when they were linked: at the beginning of 1980, as everything else in the FMU
    environment = os.environ | {"SOURCE_DATE_EPOCH": "315532800"}
    with _AT_WORK:
        done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=output.parent, env=environment)
    if done.returncode != 0:
        raise BuildError(f"the C compiler failed ({command[0]}):\n{done.stderr.strip()[-3000:]}")


@cache
def fmi_functions(fmi: FmiVersion) -> tuple[str, ...]:
    """Names of all functions of the API of an FMI version."""
    major = fmi[0]
    text = (fmi_headers() / f"fmi{major}Functions.h").read_text(encoding="utf-8")
    return tuple(re.findall(rf"^\s*FMI{major}_Export\s+\w+\s+(fmi{major}\w+);", text, re.MULTILINE))


def fmi3_functions() -> tuple[str, ...]:
    """Names of all functions of the FMI 3.0 API."""
    return fmi_functions("3.0")


def _exported(library: Path, target: Platform) -> set[str]:
    """The names that a library exports, in C's spelling."""
    import lief

    lief.logging.disable()  # it speaks of parts that no FMU needs
    parsed = lief.parse(str(library))
    if isinstance(parsed, lief.PE.Binary):
        table = parsed.get_export()
        return {str(entry.name) for entry in table.entries} if table else set()
    if isinstance(parsed, lief.ELF.Binary | lief.MachO.Binary):
        underscore = "_" if target.suffix == ".dylib" else ""
        return {str(symbol.name).removeprefix(underscore) for symbol in parsed.exported_symbols}
    raise BuildError(f"the compiled library {library.name} for {target.fmi3} cannot be read")

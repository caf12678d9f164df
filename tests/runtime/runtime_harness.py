"""Compile the runtime with a hand-written sample model and call the result through ctypes."""

from __future__ import annotations

import hashlib
import re
import shutil
import subprocess
import sys
import tempfile
from ctypes import CDLL, byref, c_bool, c_double, c_int32, c_int64, c_size_t, c_uint8, c_uint32, c_uint64, c_void_p
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple, Self

import fmpy
from fmpy import platform, platform_tuple, sharedLibraryExtension
from fmpy.fmi3 import fmi3LogMessageCallback

HERE = Path(__file__).parent
RUNTIME = HERE.parents[1] / "src" / "cosim" / "fmu" / "runtime"
HEADERS = Path(fmpy.__file__).parent / "c-code"
SIZES = ("NX", "NZ", "NU", "NP", "ND", "NG", "NS", "NY", "NL", "NA", "NE", "NVARIABLES")
TOKEN = "{sample}"
KINDS: dict[str, Any] = {
    "Float64": c_double,
    "Int32": c_int32,
    "Boolean": c_bool,
    "Int64": c_int64,
    "UInt64": c_uint64,
}


def compiler() -> list[str]:
    """The C compiler of the build extra, else the system's."""
    try:
        import ziglang  # noqa: F401
    except ImportError:
        found = shutil.which("cc") or shutil.which("gcc")
        assert found, "no C compiler"
        return [found]
    return [sys.executable, "-m", "ziglang", "cc"]


def write_sizes(model: Path, folder: Path) -> None:
    sizes = dict.fromkeys(SIZES, "0")
    line = re.search(r"sizes:(.*)", model.read_text())
    assert line, f"{model} has no line 'sizes:'"
    sizes.update(re.findall(r"(\w+)=(\d+)", line.group(1)))
    lines = [f"#define MODEL_{name} {value}" for name, value in sizes.items()]
    lines += [f'#define MODEL_TOKEN "{TOKEN}"', f'#define MODEL_NAME "{model.stem}"']
    (folder / "model_sizes.h").write_text("\n".join(lines) + "\n")


def runtime_sources(fmi: int) -> list[Path]:
    """The runtime with the shell of one FMI version."""
    other = f"fmi{5 - fmi}"
    return [path for path in sorted(RUNTIME.glob("*.c")) if not path.name.startswith(other)]


def library_of(name: str, folder: Path, fmi: int = 3) -> Path:
    """Where the FMU folder of a sample has its shared library."""
    target = platform_tuple if fmi == 3 else platform
    return folder / "binaries" / str(target) / f"{name}{sharedLibraryExtension}"


def build(name: str, folder: Path, command: list[str], *flags: str, fmi: int = 3) -> Path:
    """Compile the sample into folder and return the shared library."""
    model = HERE / "models" / f"{name}.c"
    folder.mkdir(parents=True, exist_ok=True)
    write_sizes(model, folder)
    library = library_of(name, folder, fmi)
    library.parent.mkdir(parents=True, exist_ok=True)
    includes = ["-isystem", HEADERS, "-I", RUNTIME, "-I", folder, "-I", model.parent]
    flags = ("-fPIC", "-shared", "-fvisibility=hidden", "-ffp-contract=off", "-std=c11", *flags)
    sources = [model, *runtime_sources(fmi)]
    arguments = [*command, *flags, *includes, *sources, "-lm", "-o", library]
    done = subprocess.run([str(part) for part in arguments], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return library


@cache
def built(name: str, fmi: int = 3) -> Path:
    """The unzipped FMU folder of a sample, compiled once per content of its sources."""
    sources = [HERE / "models" / f"{name}.c", HERE / "models" / "sample.h", *sorted(RUNTIME.glob("*.[ch]"))]
    digest = hashlib.sha256(b"".join(path.read_bytes() for path in sources) + HEADERS.as_posix().encode()).hexdigest()
    folder = Path(tempfile.gettempdir()) / "cosim-runtime-tests" / f"{name}-fmi{fmi}-{digest[:16]}"
    library = library_of(name, folder, fmi)
    if not library.exists():
        with tempfile.TemporaryDirectory() as scratch:
            build(name, Path(scratch), compiler(), "-O2", fmi=fmi)
            folder.parent.mkdir(exist_ok=True)
            staging = Path(tempfile.mkdtemp(dir=folder.parent))
            shutil.copytree(scratch, staging, dirs_exist_ok=True)
            try:
                staging.rename(folder)
            except OSError:  # another process was faster
                shutil.rmtree(staging)
    return folder


class Step(NamedTuple):
    """What fmi3DoStep returned."""

    event: bool
    terminate: bool
    early: bool
    time: float


class Update(NamedTuple):
    """What fmi3UpdateDiscreteStates returned."""

    terminate: bool
    reinitialised: bool
    next_time: float | None


class FmiError(Exception):
    """An FMI function returned a status other than OK; the text is what it logged."""


class Sample:
    """An instance of a sample model; its methods call FMI functions and raise FmiError if one does not return OK."""

    def __init__(
        self,
        name: str,
        *,
        folder: Path | None = None,
        token: str = TOKEN,
        events: bool = False,
        early: bool = False,
        logging: bool = False,
    ) -> None:
        self.log: list[str] = []
        self._callback = fmi3LogMessageCallback(lambda _env, _status, _category, text: self.log.append(text.decode()))
        library = library_of(name, folder or built(name))
        self.dll = CDLL(str(library))
        instantiate = self.dll.fmi3InstantiateCoSimulation
        instantiate.restype = c_void_p
        instance = instantiate(
            name.encode(), token.encode(), None, c_bool(False), c_bool(logging), c_bool(events), c_bool(early),
            None, c_size_t(0), None, self._callback, None,
        )  # fmt: skip
        if not instance:
            raise FmiError("\n".join(self.log))
        self.instance = c_void_p(instance)
        self.time = 0.0

    def call(self, function: str, *arguments: object) -> None:
        """Call an FMI function with the instance and these arguments."""
        self.log.clear()
        status = getattr(self.dll, function)(self.instance, *arguments)
        if status != 0:
            raise FmiError("\n".join(self.log) or f"{function} returned {status} and logged nothing")

    def free(self) -> None:
        self.dll.fmi3FreeInstance(self.instance)

    def enter(self, tolerance: float | None = None, start: float = 0.0, stop: float | None = None) -> Self:
        self.time = start
        self.call(
            "fmi3EnterInitializationMode", c_bool(tolerance is not None), c_double(tolerance or 0.0), c_double(start),
            c_bool(stop is not None), c_double(stop or 0.0),
        )  # fmt: skip
        return self

    def exit(self) -> Self:
        self.call("fmi3ExitInitializationMode")
        return self

    def start(self, tolerance: float | None = None, start: float = 0.0, **parameters: float) -> Self:
        """Set the parameters given as v<value reference>, then initialise."""
        for name, value in parameters.items():
            self.set(int(name[1:]), value)
        return self.enter(tolerance, start).exit()

    def step(self, h: float) -> Step:
        """Step by h from where the last step ended."""
        return self.step_to(self.time + h)

    def step_to(self, end: float) -> Step:
        event, terminate, early, last = c_bool(), c_bool(), c_bool(), c_double()
        self.call(
            "fmi3DoStep", c_double(self.time), c_double(end - self.time), c_bool(True),
            byref(event), byref(terminate), byref(early), byref(last),
        )  # fmt: skip
        self.time = last.value
        return Step(event.value, terminate.value, early.value, last.value)

    def update(self) -> Update:
        """fmi3UpdateDiscreteStates in Event Mode."""
        need, terminate, nominals, values, defined = (c_bool() for _ in range(5))
        time = c_double()
        self.call(
            "fmi3UpdateDiscreteStates", byref(need), byref(terminate), byref(nominals), byref(values), byref(defined),
            byref(time),
        )  # fmt: skip
        assert not need.value
        return Update(terminate.value, values.value, time.value if defined.value else None)

    def get(self, *references: int, kind: str = "Float64") -> Any:  # noqa: ANN401
        """The value, or a list of the values if there are several references."""
        values = (KINDS[kind] * len(references))()
        n = len(references)
        self.call(f"fmi3Get{kind}", (c_uint32 * n)(*references), c_size_t(n), values, c_size_t(n))
        return values[0] if n == 1 else list(values)

    def set(self, reference: int, value: float, kind: str = "Float64") -> None:
        kind_ = KINDS[kind]
        self.call(f"fmi3Set{kind}", (c_uint32 * 1)(reference), c_size_t(1), (kind_ * 1)(kind_(value)), c_size_t(1))

    def counters(self, first: int) -> dict[str, int]:
        """The solver's counters, whose value references begin at first."""
        names = ("steps", "rejected", "rhs", "jacobians", "state_events", "time_events")
        return dict(zip(names, self.get(*range(first, first + 6), kind="UInt64"), strict=True))

    def save(self) -> c_void_p:
        state = c_void_p()
        self.call("fmi3GetFMUState", byref(state))
        return state

    def restore(self, state: c_void_p) -> None:
        self.call("fmi3SetFMUState", state)

    def forget(self, state: c_void_p) -> None:
        self.call("fmi3FreeFMUState", byref(state))

    def serialize(self, state: c_void_p) -> bytes:
        size = c_size_t()
        self.call("fmi3SerializedFMUStateSize", state, byref(size))
        buffer = (c_uint8 * size.value)()
        self.call("fmi3SerializeFMUState", state, buffer, size)
        return bytes(buffer)

    def deserialize(self, data: bytes) -> c_void_p:
        state = c_void_p()
        buffer = (c_uint8 * len(data)).from_buffer_copy(data)
        self.call("fmi3DeserializeFMUState", buffer, c_size_t(len(data)), byref(state))
        return state

"""Peers: which there are, which environment each needs, and a session with one in a process of its own."""

from __future__ import annotations

import json
import os
import select
import subprocess
import sys
import time
import venv
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import TracebackType

from _worker import Answer, Job
from platformdirs import user_cache_path

HERE = Path(__file__).parent
ENVIRONMENTS: dict[str, tuple[str, ...]] = {
    "bench": ("fmpy", "fmu-manipulation-toolbox", "ecospy", "tbb", "libcosimpy"),
    "cofmupy": ("cofmupy",),
    "sofirpy": ("sofirpy", "setuptools<80"),
    "pathsim": ("pathsim-fmi",),
}
"""What pip installs into each environment; those of "bench" may also be in the project's own."""


@dataclass(frozen=True)
class Peer:
    """A system to compare with: its name in tables, the script and variant that run it, and where it is installed."""

    name: str
    script: str
    variant: str = ""
    environment: str = "bench"
    module: str = "fmpy"


OURS = (
    Peer("cosim, gauss-seidel (default)", "ours", "gauss-seidel", "", "cosim"),
    Peer("cosim, jacobi", "ours", "jacobi", "", "cosim"),
)
PEERS = (
    Peer("fmpy, loop written by hand", "fmpy_loop"),
    Peer("fmpy, SSP", "fmpy_ssp"),
    Peer("fmpy container", "fmpy_container", "simulate_fmu", module="fmpy.container_fmu"),
    Peer("fmu-manipulation-toolbox container", "fmutool_container", "simulate_fmu", module="fmu_manipulation_toolbox"),
    Peer("ecos", "ecos", module="ecospy"),
    Peer("libcosim", "libcosim", module="libcosimpy"),
    Peer("sofirpy", "sofir", "", "sofirpy", "sofirpy"),
    Peer("CoFmuPy, jacobi", "cofmu", "jacobi", "cofmupy", "cofmupy"),
    Peer("PathSim", "pathsim_blocks", "", "pathsim", "pathsim_fmi"),
)


class PeerError(Exception):
    """A peer is missing, has failed, or has ended its process."""


def environments() -> Path:
    """Return the folder of the peers' environments: COSIM_PEERS, or one in the user's cache."""
    chosen = os.environ.get("COSIM_PEERS")
    return Path(chosen) if chosen else user_cache_path("wiper-cosim") / "peers"


def install() -> None:
    """Create the environments and install the peers."""
    for name, packages in ENVIRONMENTS.items():
        folder = environments() / name
        venv.create(folder, with_pip=True)
        subprocess.run([_python(folder), "-m", "pip", "install", "--quiet", *packages], check=True)


@cache
def interpreter(peer: Peer) -> str | None:
    """Return the interpreter that can import the peer, its own environment's or this one, or None."""
    own = environments() / peer.environment
    for python in (_python(own) if peer.environment else sys.executable, sys.executable):
        if Path(python).exists():
            probe = f"import importlib.util as u, sys; sys.exit(u.find_spec({peer.module!r}) is None)"
            if subprocess.run([python, "-c", probe], capture_output=True, check=False).returncode == 0:
                return python
    return None


def _python(folder: Path) -> str:
    return str(folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python"))


class Session:
    """A peer at work in its own process. ``versions`` and ``import_s`` are what it says of itself."""

    def __init__(self, peer: Peer) -> None:
        """Start the process; raises PeerError if the peer is not installed or does not start."""
        python = interpreter(peer)
        if python is None:
            raise PeerError(f"{peer.module} is not installed; run: python benchmarks/peers.py --install")
        self.peer = peer
        self.started = time.perf_counter()
        self._process = subprocess.Popen(
            [python, str(HERE / f"{peer.script}.py")],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        hello = self._read(120.0)
        self.versions: dict[str, str] = hello["versions"]
        self.import_s: float = hello["import_s"]

    def run(self, job: Job, timeout: float = 600.0) -> Answer:
        """Run a job; raises PeerError."""
        assert self._process.stdin is not None
        try:
            print(json.dumps(job | {"variant": self.peer.variant}), file=self._process.stdin, flush=True)
        except BrokenPipeError as error:
            raise PeerError("the process has ended") from error
        answer = self._read(timeout)
        if "error" in answer:
            raise PeerError(str(answer["error"]).splitlines()[0])
        return answer

    def _read(self, timeout: float):  # noqa: ANN202 - whatever the worker says
        assert self._process.stdout is not None
        ready, _, _ = select.select([self._process.stdout], [], [], timeout)
        if not ready:
            self._process.kill()
            raise PeerError(f"no answer within {timeout:g} s")
        line = self._process.stdout.readline()
        if not line:
            code = self._process.wait()
            raise PeerError(f"ends its process (code {code})")
        return json.loads(line)

    def __enter__(self) -> Session:
        """Return the session."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the process."""
        self._process.communicate()

"""The worker side of a peer: takes jobs on standard input, runs them in the peer, answers on standard output.

A worker runs in the peer's own environment, so it may import nothing but the peer and the standard library.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable
from importlib.metadata import version
from typing import TypedDict

STARTED = time.perf_counter()


class Part(TypedDict):
    """One FMU of the system: its name in it, its file, and its parameters."""

    name: str
    path: str
    parameters: dict[str, float]


class Job(TypedDict):
    """A system and how to run it, with a row every ``every`` macro steps of ``step`` [s] until ``stop`` [s].

    A connection is [source component, output, target component, input]; an output to record [component, variable].
    ``folder`` is for files of the run, ``variant`` one of the peer's own ways of running.
    """

    parts: list[Part]
    connections: list[list[str]]
    outputs: list[list[str]]
    step: float
    stop: float
    every: int
    folder: str
    variant: str


class Answer(TypedDict):
    """What a run took [s], without loading and initialising the FMUs, and its rows: "time" and "component.variable"."""

    seconds: float
    rows: dict[str, list[float]]


def serve(run: Callable[[Job], Answer], *packages: str) -> None:
    """Say who answers and how long it took to import, then run jobs until standard input ends."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # peers print there, some of them from C
    hello = {"versions": {name: version(name) for name in packages}, "import_s": time.perf_counter() - STARTED}
    print(json.dumps(hello), file=answers, flush=True)
    for line in sys.stdin:
        try:
            answer: object = run(json.loads(line))
        except Exception as error:  # whatever a peer raises is its answer
            answer = {"error": f"{type(error).__name__}: {error}"}
        print(json.dumps(answer), file=answers, flush=True)
    answers.flush()
    os._exit(0)  # some peers crash while the interpreter shuts down


def row_count(job: Job) -> int:
    """Return the number of rows after the first."""
    return round(job["stop"] / job["step"]) // job["every"]


def names(job: Job) -> list[str]:
    """Return the names of the recorded columns."""
    return [".".join(output) for output in job["outputs"]]


def table(job: Job, rows: list[tuple[float, ...]]) -> dict[str, list[float]]:
    """Return the columns of rows that hold the time and the outputs."""
    return dict(zip(["time", *names(job)], map(list, zip(*rows, strict=True)), strict=True))

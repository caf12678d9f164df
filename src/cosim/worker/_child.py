"""The life of a worker: it waits for its job, does it, answers, and ends."""

from __future__ import annotations

import contextlib
import ctypes
import os
import pickle
import sys
import threading
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

from cosim.worker._memory import limit_memory
from cosim.worker._messages import receive, send
from cosim.worker._shared import attach


def work(reference: str, jobs: int, answers: int) -> NoReturn:
    """Do one job: a function, called with the shared memory, a function that answers, and its arguments.

    ``jobs`` and ``answers`` are channels to the parent, the memory is called ``reference``.
    """
    request = receive(jobs)
    if request is None:
        os._exit(0)
    threading.Thread(target=_end_with, args=(jobs,), daemon=True).start()
    answered = False

    def answer(content: object) -> None:
        nonlocal answered
        if not answered:
            answered = True
            send(answers, pickle.dumps(content))

    try:
        environment, folder, request = pickle.loads(request)
        os.environ.clear()
        os.environ.update(environment)
        if folder:
            os.chdir(folder)
        function, size, most_memory, arguments = pickle.loads(request)
        limit_memory(most_memory)
        function(attach(reference, size), answer, *arguments)
    except BaseException as error:
        answer(_portable(error))
    with contextlib.suppress(Exception):  # what FMUs have printed
        ctypes.CDLL(None if sys.platform != "win32" else "ucrtbase").fflush(None)
    os._exit(0)


Answer = Callable[[object], None]
"""Hands an answer to the parent; the first one counts. An exception is raised there."""


def working_folder() -> str:
    """Return the folder that this process works in; an empty text if it has been removed."""
    try:
        return str(Path.cwd())
    except OSError:
        return ""


def quiet_channels(null: int) -> None:
    """Let what FMUs read be empty, and what they print go to stderr, or nowhere if there is none."""
    os.dup2(null, 0)
    try:
        os.dup2(2, 1)
    except OSError:
        os.dup2(null, 1)


def _end_with(jobs: int) -> None:
    """End this process when the parent has ended or lets it go."""
    os.read(jobs, 1)
    os._exit(1)


def _portable(error: BaseException) -> BaseException:
    """Return the error, or what can be said of it if it cannot be handed on."""
    text = "".join(traceback.format_exception(error))
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return RuntimeError(text)
    error.add_note(f"in the worker:\n{text}")
    return error

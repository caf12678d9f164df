"""The worker as a piece of machinery, without an engine: answers, deaths in words, limits, channels."""

from __future__ import annotations

import os
import signal
import sys
import time

import pytest

from cosim.worker import Death, Worker, machine_memory
from cosim.worker._memory import limit_memory
from cosim.worker._messages import Message, receive, send


@pytest.mark.parametrize(
    ("code", "crashed", "text"),
    [
        (0, False, "exit code 0"),
        (7, False, "exit code 7"),
        (-11, True, "SIGSEGV (it used memory that it does not have)"),
        (-9, True, "SIGKILL (it was ended from outside, as the system does when memory runs out)"),
        (-10, True, "SIGUSR1"),
        (-200, True, "signal 200"),
        (0xC0000005, True, "an access violation (it used memory that it does not have)"),
        (0xC0000005 - 2**32, True, "an access violation (it used memory that it does not have)"),
        (0xC00000FD, True, "a stack overflow (its calls are nested too deeply)"),
        (0xC0000094, True, "an integer division by 0 (an arithmetic fault)"),
    ],
)
@pytest.mark.skipif(sys.platform != "linux", reason="signals have other numbers elsewhere")
def test_deaths_in_words(code: int, crashed: bool, text: str) -> None:
    death = Death(code)
    assert str(death) == text
    assert death.crashed is crashed


def finished(worker: Worker) -> Worker:
    deadline = time.perf_counter() + 20.0
    while not worker.wait(0.05):
        assert time.perf_counter() < deadline
    return worker


def test_a_job_that_cannot_be_done_answers_with_its_error() -> None:
    with Worker() as worker:
        worker.map(1)
        worker.start(os.strerror, most_memory=float("inf"))
        answer = finished(worker).answer
    assert isinstance(answer, TypeError)
    assert answer.__notes__[0].startswith("in the worker:\nTraceback")
    assert worker.death == Death(0, worker.death.memory)


def test_a_worker_that_is_killed_before_it_has_a_job() -> None:
    with Worker() as worker:
        worker.kill()
        assert worker.wait(0.0)
        assert worker.answer is None


def test_a_worker_that_is_ended_from_outside() -> None:
    with Worker() as worker:
        worker.map(1)
        worker.start(time.sleep, most_memory=float("inf"))
        finished(worker)
    with Worker() as worker:
        worker.map(1)
        worker.kill()
        assert sys.platform == "win32" or worker.death.code in (0, -signal.SIGKILL)


def test_messages_arrive_in_whatever_pieces_they_come() -> None:
    source, sink = os.pipe()
    message = Message()
    content = bytes(range(256)) * 3
    for byte in len(content).to_bytes(8, "little") + content:
        assert message.content is None
        os.write(sink, bytes([byte]))
        assert message.take(source)
    assert message.content == content
    send(sink, b"")
    assert receive(source) == b""
    os.close(sink)
    assert receive(source) is None
    os.close(source)


def test_memory_is_that_of_the_machine_at_most() -> None:
    assert 1e8 < machine_memory() <= os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")


@pytest.mark.skipif(sys.platform != "linux", reason="memory is limited on Linux only")
def test_a_limit_makes_memory_run_out() -> None:
    child = os.fork()
    if child == 0:
        try:
            limit_memory(2e9)
            bytearray(3 * 10**9)
        except MemoryError:
            os._exit(5)
        os._exit(0)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 5

"""Has the rules on running applied in processes of their own, so that an FMU that crashes or hangs is a finding."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import fmpy

import cosim.check._slopes  # noqa: F401 - adds its rules
from cosim.check._rules import Finding, Severity
from cosim.check._run_rules import RUN_RULES
from cosim.check._subject import Subject

CRASH, HANG = "run.crash", "run.hang"
EXTRA = (
    (CRASH, Severity.ERROR, "No call crashes or ends the process that runs the FMU."),
    (HANG, Severity.ERROR, "No call takes longer than --timeout."),
    (
        "run.left-out",
        Severity.NOTE,
        "The FMU can be run here: there is a binary for this computer, and no tool needed.",
    ),
)
_POLL = 0.02
_FIRST = RUN_RULES[0].id
Job = tuple[str, str]


def run_trials(subject: Subject, timeout: float) -> tuple[list[Finding], list[str]]:
    """Run an FMU's binary by the rules; return the findings, and the ids of the rules that were applied.

    ``timeout`` [s] is how long each may take.
    """
    findings: list[Finding] = []
    jobs: list[Job] = []
    for interface in subject.interfaces:
        reason = _reason_against(subject, interface)
        if reason is None:
            jobs += [(interface, rule.id) for rule in RUN_RULES if _fits(subject, interface, rule.instances)]
        else:
            findings.append(Finding("run.left-out", Severity.NOTE, f"is not run: {reason}", interface, ""))
    applied = list(dict.fromkeys(name for _, name in jobs))
    if jobs:
        with tempfile.TemporaryDirectory(prefix="cosim-check-", ignore_cleanup_errors=True) as folder:
            unpacked = Path(folder, "fmu")
            unpacked.mkdir()
            subject.archive.extract(unpacked)
            while jobs:
                single = _is_alone(subject, jobs[0][0])
                batch = jobs[:1] if single else jobs
                found, done = _session(subject, unpacked, batch, Path(folder, "findings"), timeout)
                findings += found
                jobs = [job for job in jobs if job not in done]
    return findings, applied


def _reason_against(subject: Subject, interface: str) -> str | None:
    """Tell why an interface cannot be run here; None if it can."""
    if subject.fmi == 1 or interface == "ScheduledExecution":
        return "the check does not run it"
    description = subject.interfaces[interface]
    if description.needsExecutionTool:
        return f"it needs its tool, {subject.description.generationTool or 'whichever that is'}"
    if not description.modelIdentifier or not subject.description.guid:
        return "it has no modelIdentifier or token"
    folder = fmpy.platform if subject.fmi == 2 else fmpy.platform_tuple
    if f"binaries/{folder}/{description.modelIdentifier}{fmpy.sharedLibraryExtension}" not in subject.archive:
        return f"it has no binary for this computer ({folder})"
    return None


def _is_alone(subject: Subject, interface: str) -> bool:
    return subject.claims(interface, "canBeInstantiatedOnlyOncePerProcess")


def _fits(subject: Subject, interface: str, instances: int) -> bool:
    return instances == 1 or not _is_alone(subject, interface)


def _session(
    subject: Subject, folder: Path, jobs: list[Job], out: Path, timeout: float
) -> tuple[list[Finding], set[Job]]:
    """Run one process until it is done, dead or too slow; return what it found, and which jobs are over."""
    out.write_text("", encoding="utf-8")
    order = {"path": str(subject.archive.path.resolve()), "folder": str(folder), "jobs": jobs, "out": str(out)}
    with out.with_suffix(".err").open("wb") as errors:
        process = subprocess.Popen(
            [sys.executable, "-m", "cosim.check._worker", json.dumps(order)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=errors,
            cwd=folder,
        )
        is_slow = _wait(process, out, timeout)
    findings: list[Finding] = []
    done: set[Job] = set()
    running: Job = jobs[0]
    is_over = True
    for message in _messages(out):
        running = (message["job"][0], message["job"][1])
        is_over = "begun" not in message
        if is_over:
            done.add(running)
            findings += _of_message(message, running)
            if "failed" in message and running[1] == _FIRST:
                done.update(job for job in jobs if job[0] == running[0])
    if is_over and not done and not is_slow:
        said = out.with_suffix(".err").read_text(encoding="utf-8", errors="replace")
        raise RuntimeError(f"the process that checks the FMU did not get to work:\n{said[-3000:]}")
    if not is_over or not done:
        done.update(job for job in jobs if job == running or (running[1] == _FIRST and job[0] == running[0]))
        findings.append(_end(process.returncode, running, timeout if is_slow else None))
    return findings, done


def _wait(process: subprocess.Popen[bytes], out: Path, timeout: float) -> bool:
    """Wait for the process; kill it if it writes nothing for too long, and tell so."""
    size, since = 0, time.monotonic()
    while True:
        try:
            process.wait(_POLL)
            return False
        except subprocess.TimeoutExpired:
            pass
        if (now := out.stat().st_size) != size:
            size, since = now, time.monotonic()
        if time.monotonic() - since > timeout:
            process.kill()
            process.wait()
            return True


def _messages(out: Path) -> Iterator[dict[str, Any]]:
    for line in out.read_text(encoding="utf-8").splitlines():
        try:
            yield json.loads(line)
        except ValueError:  # the process died while it wrote
            return


def _of_message(message: dict[str, Any], job: Job) -> list[Finding]:
    interface, name = job
    if "failed" in message:
        rule = next(rule for rule in RUN_RULES if rule.id == name)
        return [Finding(name, Severity.ERROR, f"{message['failed']}", interface, "tell whoever exported the FMU")] * (
            rule.severity > Severity.NOTE
        )
    return [
        Finding(
            one["rule"],
            Severity(one["severity"]),
            one["what"],
            f"{interface}: {one['where']}" if one["where"] else interface,
            one["remedy"],
        )
        for one in message["findings"]
    ]


def _end(code: int, job: Job, timeout: float | None) -> Finding:
    """Return the finding for a process that did not come to its end."""
    interface, name = job
    doing = f"while the rule {name} was tried"
    if timeout is not None:
        what = f"has not come back after {timeout:g} s, {doing}"
        return Finding(HANG, Severity.ERROR, what, interface, "give it longer with --timeout, or mend the FMU")
    if code < 0:
        how = f"crashes with {signal.Signals(-code).name}"
    elif code > 255:
        how = f"crashes with the code 0x{code:08X}"
    else:
        how = f"ends the process with the exit code {code}"
    return Finding(CRASH, Severity.ERROR, f"{how}, {doing}", interface, "tell whoever exported the FMU")

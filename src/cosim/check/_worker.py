"""The process that runs an FMU's binary: applies the rules it is told, and writes what it finds, line by line."""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

import cosim.check._slopes  # noqa: F401 - adds its rules
from cosim.archive import Archive
from cosim.check._bench import Bench
from cosim.check._run_rules import RUN_RULES
from cosim.check._subject import Subject
from cosim.foreign import read_description


def work(path: str, folder: str, jobs: list[tuple[str, str]], out: str) -> None:
    """Apply rules to interfaces, ``jobs`` being pairs of both, to the FMU that was unpacked into a folder."""
    archive = Archive.open(path)
    subject = Subject(archive, read_description(archive))
    by_id = {rule.id: rule for rule in RUN_RULES}
    with Path(out).open("a", encoding="utf-8") as stream:
        failed: set[str] = set()
        for interface, name in jobs:
            if interface in failed:
                continue
            _tell(stream, {"job": [interface, name], "begun": True})
            answer: dict[str, object] = {"job": [interface, name]}
            try:
                found = by_id[name].apply(Bench(subject, interface, Path(folder)))
                answer["findings"] = [asdict(finding) for finding in found]
            except Exception as error:
                answer["failed"] = "; ".join([str(error) or type(error).__name__, *getattr(error, "__notes__", [])])
                if name == RUN_RULES[0].id:
                    failed.add(interface)
            _tell(stream, answer)


def _tell(stream: Any, message: dict[str, object]) -> None:  # noqa: ANN401
    stream.write(json.dumps(message) + "\n")
    stream.flush()


if __name__ == "__main__":
    work(**json.loads(sys.argv[1]))

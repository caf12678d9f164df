"""Runs a job in a container FMU of fmu-manipulation-toolbox; the variants of ``_container``, and "... sequential"."""

from __future__ import annotations

import shutil
from pathlib import Path

from _container import run_container
from _worker import Answer, Job, serve
from fmu_manipulation_toolbox.assembly import AssemblyNode

PREFIX = "out."  # a container has variables of its own, named "component.output", for the connections


def run(job: Job) -> Answer:
    sequential = job["variant"].endswith(" sequential")
    job["variant"] = job["variant"].removesuffix(" sequential")
    folder = Path(job["folder"])
    path = folder / f"fmutool_{job['step']:g}_{sequential}.fmu"
    if not path.exists():
        build(job, folder, path.name, sequential)
    return run_container(path, job, PREFIX)


def build(job: Job, folder: Path, name: str, sequential: bool) -> None:
    """Build the container; all FMUs must lie in its folder."""
    version = 3
    node = AssemblyNode(
        name, step_size=job["step"], sequential=sequential, auto_link=False, auto_input=False, auto_output=False
    )
    for part in job["parts"]:
        file = f"{part['name']}.fmu"
        if not (folder / file).exists():
            shutil.copyfile(part["path"], folder / file)
        if Path(part["path"]).stem.endswith("2"):
            version = 2
        node.add_fmu(file)
        for key in part["parameters"]:
            node.add_input(f"{part['name']}.{key}", file, key)
    for a, out, b, into in job["connections"]:
        node.add_link(f"{a}.fmu", out, f"{b}.fmu", into)
    for owner, variable in job["outputs"]:
        node.add_output(f"{owner}.fmu", variable, f"{PREFIX}{owner}.{variable}")
    node.make_fmu(folder, fmi_version=version)


if __name__ == "__main__":
    serve(run, "fmu-manipulation-toolbox", "FMPy")

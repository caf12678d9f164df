"""Runs a job in a container FMU of fmpy; the variants of ``_container``."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path
from tempfile import mkdtemp

from _container import run_container
from _worker import Answer, Job, serve
from attrs import evolve
from fmpy import read_model_description
from fmpy.container_fmu.cli import create_container_fmu
from fmpy.container_fmu.config import Component, Configuration, Connection
from fmpy.model_description import CoSimulation, ModelDescription, ModelVariable, Unknown


def run(job: Job) -> Answer:
    path = Path(job["folder"]) / f"fmpy_{job['step']:g}.fmu"
    if not path.exists():
        build(job, path)
    return run_container(path, job)


def build(job: Job, path: Path) -> None:
    """Build the container."""
    components = {
        part["name"]: Component(part["name"], Path(part["path"]), read_model_description(part["path"]))
        for part in job["parts"]
    }
    variables = {
        (name, variable.name): variable
        for name, component in components.items()
        for variable in component.modelDescription.modelVariables
    }
    version = next(iter(components.values())).modelDescription.fmiVersion
    description = ModelDescription(
        fmiVersion=version,
        modelName="container",
        instantiationToken="container",
        coSimulation=CoSimulation(modelIdentifier="container_fmu", fixedInternalStepSize=job["step"]),
    )
    clock = ModelVariable(name="time", type="Real" if version == "2.0" else "Float64", causality="independent")
    clock.variability = "continuous"
    description.modelVariables.append(clock)
    mappings: dict[ModelVariable, list[tuple[Component, ModelVariable]]] = {}
    exposed = [(owner, variable) for owner, variable in job["outputs"]]
    exposed += [(part["name"], key) for part in job["parts"] for key in part["parameters"]]
    values = {(part["name"], key): value for part in job["parts"] for key, value in part["parameters"].items()}
    for owner, name in exposed:
        inner = variables[owner, name]
        outer = evolve(inner, name=f"{owner}.{name}", unit=None, declaredType=None)
        if (owner, name) in values:
            outer.start = str(values[owner, name])
        description.modelVariables.append(outer)
        mappings[outer] = [(components[owner], inner)]
        if outer.causality == "output":
            description.outputs.append(Unknown(variable=outer))
    connections = [
        Connection(components[a], [variables[a, out]], components[b], [variables[b, into]])
        for a, out, b, into in job["connections"]
    ]
    configuration = Configuration(False, description, list(components.values()), connections, mappings)
    create_container_fmu(configuration, Path(mkdtemp()), path)
    if version == "2.0":
        _correct_types(path)


def _correct_types(path: Path) -> None:
    """Write the connections' types as the container reads them: the writer gives those of FMI 2.0."""
    with zipfile.ZipFile(path) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    settings = json.loads(files["resources/container.json"])
    for connection in settings["connections"]:
        connection["variableType"] = {"Real": "Float64", "Integer": "Int32"}[connection["variableType"]]
    files["resources/container.json"] = json.dumps(settings).encode()
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in files.items():
            archive.writestr(name, content)


if __name__ == "__main__":
    serve(run, "FMPy")

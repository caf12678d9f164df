"""Runs a job as a system structure (SSP 1.0) in fmpy. It records every macro step and labels a row with its begin."""

from __future__ import annotations

import time
import zipfile
from pathlib import Path

from _worker import Answer, Job, Part, names, serve
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import Parameter, ParameterSet

_HEAD = """<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription version="1.0" name="pair"
  xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon"
  xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"><ssd:System name="pair">"""


def run(job: Job) -> Answer:
    archive = write(job)
    parameters = ParameterSet(name="parameters")
    for part in job["parts"]:
        for key, value in part["parameters"].items():
            parameters.parameters.append(Parameter(name=f"{part['name']}.{key}", type="Real", value=value))

    def simulate(stop: float):  # noqa: ANN202 - a structured array
        begun = time.perf_counter()
        # It steps while time < stop, with a time that has been added up, and would take one step too many.
        result = simulate_ssp(
            str(archive), stop_time=stop - 0.5 * job["step"], step_size=job["step"], parameter_set=parameters
        )
        return time.perf_counter() - begun, result

    set_up, _ = simulate(job["step"])
    seconds, result = simulate(job["stop"])
    every = job["every"]
    rows = {"time": result["time"][every - 1 :: every].tolist()}
    for name in names(job):
        rows[name] = result[name][every - 1 :: every].tolist()
    return {"seconds": seconds - set_up, "rows": rows}


def write(job: Job) -> Path:
    """Write the SSP of a job."""
    path = Path(job["folder"]) / "pair.ssp"
    elements = "".join(_component(job, part) for part in job["parts"])
    connections = "".join(
        f'<ssd:Connection startElement="{a}" startConnector="{out}" endElement="{b}" endConnector="{into}"/>'
        for a, out, b, into in job["connections"]
    )
    with zipfile.ZipFile(path, "w") as archive:
        for part in job["parts"]:
            archive.write(part["path"], f"resources/{part['name']}.fmu")
        archive.writestr(
            "SystemStructure.ssd",
            f"{_HEAD}<ssd:Elements>{elements}</ssd:Elements><ssd:Connections>{connections}</ssd:Connections>"
            "</ssd:System></ssd:SystemStructureDescription>",
        )
    return path


def _component(job: Job, part: Part) -> str:
    name = part["name"]
    outputs = {v for c, v in job["outputs"] if c == name} | {v for c, v, _, _ in job["connections"] if c == name}
    inputs = {v for _, _, c, v in job["connections"] if c == name}
    connectors = "".join(
        f'<ssd:Connector name="{variable}" kind="{kind}"><ssc:Real/></ssd:Connector>'
        for kind, variables in (("output", sorted(outputs)), ("input", sorted(inputs)))
        for variable in variables
    )
    return (
        f'<ssd:Component name="{name}" type="application/x-fmu-sharedlibrary" source="resources/{name}.fmu">'
        f"<ssd:Connectors>{connectors}</ssd:Connectors></ssd:Component>"
    )


if __name__ == "__main__":
    serve(run, "FMPy")

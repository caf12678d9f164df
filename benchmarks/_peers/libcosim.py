"""Runs a job in libcosim's fixed-step algorithm. It takes FMI 2.0 only; FMI 3.0 ends the process."""

from __future__ import annotations

import time
import zipfile
from xml.etree import ElementTree

from _worker import Answer, Job, row_count, serve, table
from libcosimpy._internal import get_last_error_message
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave


def run(job: Job) -> Answer:
    execution = CosimExecution.from_step_size(round(job["step"] * 1e9))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    places: dict[str, int] = {}
    references: dict[str, dict[str, int]] = {}
    for part in job["parts"]:
        name = part["name"]
        places[name] = execution.add_local_slave(CosimLocalSlave(fmu_path=part["path"], instance_name=name))
        references[name] = value_references(part["path"])
        for key, value in part["parameters"].items():
            if not execution.real_initial_value(places[name], references[name][key], value):
                raise ValueError(f"cannot set {name}.{key}: {get_last_error_message()}")
    for a, out, b, into in job["connections"]:
        if execution.connect_real_variables(places[a], references[a][out], places[b], references[b][into]) != 0:
            raise ValueError(f"cannot connect {a}.{out} to {b}.{into}: {get_last_error_message()}")
    recorded = {
        name: [references[name][variable] for owner, variable in job["outputs"] if owner == name] for name in places
    }

    def row() -> tuple[float, ...]:
        values = {name: iter(observer.last_real_values(places[name], wanted)) for name, wanted in recorded.items()}
        return (execution.status().current_time * 1e-9, *(next(values[name]) for name, _ in job["outputs"]))

    rows = []
    begun = time.perf_counter()
    for _ in range(row_count(job)):
        if not execution.step(job["every"]):
            raise ValueError("a step failed")
        rows.append(row())
    return {"seconds": time.perf_counter() - begun, "rows": table(job, rows)}


def value_references(path: str) -> dict[str, int]:
    """Return the value references of an FMI 2.0 FMU."""
    with zipfile.ZipFile(path) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    if root.get("fmiVersion") != "2.0":
        raise ValueError("libcosim takes FMI 2.0 only")
    return {str(v.get("name")): int(str(v.get("valueReference"))) for v in root.iter("ScalarVariable")}


if __name__ == "__main__":
    serve(run, "libcosimpy")

"""What a model does in ``when terminal()``: once, when the importer ends the simulation."""

from __future__ import annotations

from pathlib import Path

import fmpy
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

from cosim.fmu import export
from cosim.fmu.versions import FmiVersion

pytest.importorskip("rumoca")

MODEL = """
model Ending "Keeps where it was at the end"
  Real x(start=0, fixed=true) "Way";
  discrete Real last(start=-1, fixed=true) "Way at the end";
  discrete Integer ends(start=0, fixed=true) "How often it ended";
equation
  der(x) = 2;
  when {terminal(), x > 100} then
    last = x;
    ends = pre(ends) + 1;
    assert(x < 1.5, "came too far");
  end when;
end Ending;
"""


@pytest.mark.parametrize("fmi", ["2.0", "3.0"])
def test_the_last_event_is_that_of_terminate(tmp_path: Path, fmi: FmiVersion) -> None:
    source = tmp_path / "Ending.mo"
    source.write_text(MODEL, encoding="utf-8")
    path = str(export(source, "Ending", tmp_path, fmi=fmi))
    description = fmpy.read_model_description(path)
    references = {variable.name: variable.valueReference for variable in description.modelVariables}
    folder = fmpy.extract(path, unzipdir=str(tmp_path / fmi))
    logged: list[str] = []

    def started() -> FMU2Slave | FMU3Slave:
        kind = FMU2Slave if fmi == "2.0" else FMU3Slave
        fmu = kind(guid=description.guid, unzipDirectory=folder, modelIdentifier="Ending", instanceName="x")
        if isinstance(fmu, FMU2Slave):
            fmu.instantiate()
            fmu.setupExperiment(startTime=0.0)
            fmu.enterInitializationMode()
        else:
            fmu.instantiate(logMessage=lambda _e, _s, _c, text: logged.append(text.decode()))
            fmu.enterInitializationMode(startTime=0.0)
        fmu.exitInitializationMode()
        return fmu

    def values(fmu: FMU2Slave | FMU3Slave) -> tuple[float, int]:
        last, ends = [references["last"]], [references["ends"]]
        if isinstance(fmu, FMU2Slave):
            return fmu.getReal(last)[0], fmu.getInteger(ends)[0]
        return fmu.getFloat64(last)[0], fmu.getInt32(ends)[0]

    fmu = started()
    fmu.doStep(0.0, 0.6)
    assert values(fmu) == (-1.0, 0)
    fmu.terminate()
    assert values(fmu) == (pytest.approx(1.2, rel=1e-9), 1)
    fmu.freeInstance()

    fmu = started()
    fmu.doStep(0.0, 1.0)
    with pytest.raises(FMICallException):
        fmu.terminate()
    assert fmi == "2.0" or logged == ["At t = 1 s an assertion of the model is violated: came too far"]
    fmu.freeInstance()

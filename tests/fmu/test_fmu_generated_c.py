"""The generated C depends on the model alone: not on its names, not on the run, not on the machine's mood."""

from __future__ import annotations

import hashlib
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from cosim.dae import Dae, compile_dae
from cosim.fmu.codegen import generate
from cosim.fmu.layout import lay_out
from cosim.fmu.toolchain import RUNTIME
from cosim.modelica import Source, flatten

pytest.importorskip("rumoca")

LIBRARY = Path(__file__).parents[2] / "modelica" / "WiperDrive"
SMALL = Path(__file__).parents[1] / "models" / "Small"

MODELICAS_OWN = set(
    re.findall(
        r"\w+",
        """
    algorithm and annotation assert block break class connect connector constant constrainedby der discrete each else
    elseif elsewhen encapsulated end enumeration equation expandable extends external false final flow for function if
    import impure in initial inner input loop model not operator or outer output package parameter partial protected
    public pure record redeclare replaceable return stream then true type when while within Real Integer Boolean String
    time start fixed min max unit quantity displayUnit nominal stateSelect StateSelect never avoid default prefer always
    sin cos tan asin acos atan atan2 sinh cosh tanh exp log log10 sqrt abs sign noEvent smooth homotopy pre edge change
    sample floor ceil mod div rem integer reinit terminate cat zeros ones fill sum product size transpose vector scalar
    AssertionLevel error warning Documentation info
    """,
    )
)
TOKEN = re.compile(r'"(?:\\.|[^"\\])*"|//[^\n]*|/\*.*?\*/|[A-Za-z_]\w*|\d+(?:\.\d*)?(?:[eE][+-]?\d+)?|.', re.DOTALL)


def renamed(text: str, salt: str) -> str:
    """Every name that is not Modelica's own becomes a hash of other length and other alphabetical place."""

    def other(match: re.Match[str]) -> str:
        word = match.group()
        if not re.match(r"[A-Za-z_]", word) or word in MODELICAS_OWN:
            return word
        digest = hashlib.sha256(f"{salt}{word}".encode()).hexdigest()
        return chr(ord("a") + int(digest[:2], 16) % 26) + digest[2 : 6 + int(digest[6], 16)]

    return TOKEN.sub(other, text)


def compiled(text: str, model: str, folder: Path) -> tuple[Dae, str]:
    file = folder / "text.mo"
    file.write_text(text, encoding="utf-8")
    dae = compile_dae(flatten(Source.read(file), model))
    sources = generate(dae, lay_out(dae), "{token}")
    return dae, sources["model_sizes.h"] + sources["model.c"]


def without_names(code: str) -> str:
    """Identifiers numbered in the order of appearance; comments, strings and the length of lines gone."""
    said = re.compile(r'/\*.*?\*/|"(?:\\.|[^"\\])*"', re.DOTALL)
    code = re.sub(r"#include.*", "", said.sub("", code))
    interface = set(re.findall(r"\w+", said.sub("", (RUNTIME / "model.h").read_text(encoding="utf-8"))))
    seen: dict[str, str] = {}
    numbered = re.sub(
        r"[A-Za-z_]\w*",
        lambda match: match.group() if match.group() in interface else seen.setdefault(match.group(), f"n{len(seen)}"),
        code,
    )
    return " ".join(re.findall(r"\w+|[^\w\s]", numbered))


@pytest.mark.parametrize("salt", ["first", pytest.param("second", marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    "model",
    [
        pytest.param("WiperDrive.Controllers.VoltageProfile", marks=pytest.mark.slow),
        pytest.param("WiperDrive.Systems.LinkagePlant", marks=pytest.mark.slow),
        pytest.param("WiperDrive.Systems.RigPlant", marks=pytest.mark.slow),
        pytest.param("WiperDrive.Systems.SwitchedRigPlant", marks=pytest.mark.slow),
        pytest.param("WiperDrive.Electronics.ECU", marks=pytest.mark.slow),
        pytest.param("WiperDrive.Systems.ClosedLoop", marks=pytest.mark.slow),
    ],
)
def test_the_generated_code_of_the_library_does_not_depend_on_names(tmp_path: Path, model: str, salt: str) -> None:
    text = Source.read(LIBRARY).text
    other_model = renamed(model, salt)
    assert other_model != model
    dae, code = compiled(text, model, tmp_path)
    other_dae, other_code = compiled(renamed(text, salt), other_model, tmp_path)
    assert other_dae.sizes == dae.sizes
    assert [renamed(s.name, salt) for s in dae.states] == [s.name for s in other_dae.states]
    assert [renamed(s.name, salt) for s in dae.torn] == [s.name for s in other_dae.torn]
    assert without_names(other_code) == without_names(code)


@pytest.mark.parametrize("name", sorted(f.stem for f in SMALL.glob("*.mo") if f.stem not in ("package", "Parts")))
def test_the_generated_code_of_a_small_model_does_not_depend_on_names(tmp_path: Path, name: str) -> None:
    text = Source.read(SMALL).text
    _, code = compiled(text, f"Small.{name}", tmp_path)
    for salt in ("a", "b"):
        _, other = compiled(renamed(text, salt), renamed(f"Small.{name}", salt), tmp_path)
        assert without_names(other) == without_names(code)


@pytest.mark.slow
def test_the_generated_code_is_the_same_in_every_run() -> None:
    program = (
        "import sys, hashlib; from pathlib import Path\n"
        "from cosim.dae import explain; from cosim.fmu import compile_model\n"
        "from cosim.fmu.codegen import generate\n"
        "from cosim.fmu.layout import lay_out; from cosim.fmu.description import describe\n"
        "for model in sys.argv[2:]:\n"
        "    dae = compile_model(Path(sys.argv[1]), model); layout = lay_out(dae)\n"
        "    code = ''.join(generate(dae, layout, '').values()).encode() + describe(dae, layout, 'M', '')\n"
        "    print(hashlib.sha256(code + explain(dae).encode()).hexdigest())\n"
    )
    models = ["WiperDrive.Systems.LinkagePlant", "WiperDrive.Controllers.VoltageProfile"]
    runs = [
        subprocess.Popen(
            [sys.executable, "-c", program, str(LIBRARY), *models],
            env={**os.environ, "PYTHONHASHSEED": seed},
            stdout=subprocess.PIPE,
            text=True,
        )
        for seed in ("1", "4711")
    ]
    outputs = [run.communicate()[0] for run in runs]
    assert [run.returncode for run in runs] == [0, 0]
    assert outputs[0] == outputs[1]
    assert len(outputs[0].splitlines()) == 2

"""Builds the test FMUs: compiles a model of this folder and packs it with a model description."""

from __future__ import annotations

import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import fmpy

HERE = Path(__file__).parent
FMI_HEADERS = Path(fmpy.__file__).parent / "c-code"
_CFLAGS = ["-shared", "-fPIC", "-O2", "-std=c11", "-ffp-contract=off", "-w"]
_KINDS = ("Float64", "Float32", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64", "Boolean")
_FMI2_TYPES = {kind: "Integer" for kind in _KINDS if "Int" in kind} | {"Float64": "Real", "Float32": "Real"}


@dataclass(frozen=True)
class Described:
    """A variable of a test FMU; ``depends`` are the inputs an output depends on directly, None for unknown.

    ``size`` is that of an array, in FMI 3 only.
    """

    name: str
    reference: int
    causality: str
    variability: str = "continuous"
    type: str = "Float64"
    start: str | None = None
    unit: str | None = None
    depends: tuple[str, ...] | None = ()
    size: tuple[int, ...] = ()
    media_type: str | None = None
    most: int | None = None


@dataclass(frozen=True)
class Model:
    """A test model: the C file, its variables, whether it has an event mode, and the literals of its enumeration.

    ``states`` are (state, derivative) if it is for Model Exchange, with as many event ``indicators``.
    """

    source: str
    variables: tuple[Described, ...]
    has_event_mode: bool = False
    literals: tuple[str, ...] = ()
    states: tuple[tuple[str, str], ...] | None = None
    indicators: int = 0


SAMPLER = Model(
    "sampler",
    (
        Described("u", 1, "input", start="0", unit="m"),
        Described("enable", 2, "input", "discrete", "Boolean", start="true"),
        Described("T_compute", 3, "parameter", "fixed", start="0.02", unit="s"),
        Described("K", 4, "parameter", "tunable", start="1"),
        Described("updates", 11, "parameter", "fixed", "Int32", start="0"),
        Described("silent", 12, "parameter", "fixed", "Boolean", start="false"),
        Described("y", 5, "output", "discrete", unit="m/s", depends=("u", "enable")),
        Described("t_sample", 6, "output", "discrete", unit="s"),
        Described("count", 7, "output", "discrete", "Int32"),
        Described("events", 8, "output", "discrete", "Int32"),
        Described("side", 9, "output", "discrete", "Enumeration", depends=("u",)),
        Described("enabled", 10, "output", "discrete", "Boolean", depends=("enable",)),
    ),
    has_event_mode=True,
    literals=("left", "middle", "right"),
)
INTEGRATOR = Model(
    "integrator",
    (
        Described("u", 1, "input", start="0", unit="m/s"),
        Described("x0", 2, "parameter", "fixed", start="0", unit="m"),
        Described("offset", 3, "parameter", "tunable", start="0", unit="m/s"),
        Described("x", 4, "output", unit="m"),
        Described("y", 5, "output", unit="m/s", depends=("u",)),
        Described("positive", 6, "output", "discrete", "Boolean"),
        Described("solver.steps", 7, "local", "discrete", "UInt64"),
        Described("longest", 8, "local", "discrete", unit="s"),
        Described("gain", 9, "parameter", "fixed", start="1"),
    ),
)
FAULTY = Model(
    "faulty",
    (
        Described("fault", 1, "parameter", "fixed", "Enumeration", start="1"),
        Described("t_fault", 2, "parameter", "fixed", start="0", unit="s"),
        Described("y", 3, "output", unit="s"),
    ),
    literals=("none", "not_a_number", "error", "discard", "terminate", "silent_error", "fatal", "early", "talkative"),
)
PICKY = Model(
    "picky",
    (
        Described("u", 1, "input", start="0"),
        Described("heard", 2, "input", "discrete", "String", start="0"),
        Described("said", 3, "output", "discrete", "String"),
        Described("x0", 10, "parameter", "fixed", start="0"),
        Described("longest", 11, "parameter", "fixed", start="1e9", unit="s"),
        Described("wrong", 12, "parameter", "fixed", "Enumeration", start="1"),
        Described("x", 13, "output"),
        Described("lag", 14, "output", unit="s"),
    ),
    literals=(*("none", "not_a_number", "error", "discard", "terminate", "fatal", "early", "run_away", "noise"),),
)
MIRROR = Model(
    "mirror",
    tuple(
        Described(
            f"{letter}_{kind}",
            12 * (letter == "y") + number,
            causality,
            "continuous" if "Float" in kind else "discrete",
            kind,
            start={"Boolean": "false", "Enumeration": "1"}.get(kind, "0") if letter == "u" else None,
            unit="m" if kind == "Float64" else None,
        )
        for letter, causality in (("u", "input"), ("y", "output"))
        for number, kind in enumerate((*_KINDS, "Enumeration"), 1)
    ),
    literals=("left", "middle", "right"),
)
VECTOR = Model(
    "vector",
    (
        Described("last", 1, "output", unit="m"),
        Described("u", 10, "input", start="0.5 1.5 2.5", unit="m", size=(3,)),
        Described("K", 20, "parameter", "fixed", start="1", size=(3, 1)),
        Described("y", 30, "output", unit="m", size=(3,)),
        Described("n", 40, "input", "discrete", "Int16", start="0", size=(3,)),
        Described("m", 50, "output", "discrete", "Int16", size=(3,)),
    ),
)
LABEL = Model(
    "label",
    (
        Described("u", 1, "input", "discrete", "String", start="nothing"),
        Described("y", 2, "output", "discrete", "String"),
        Described("name", 3, "parameter", "fixed", "String", start="step"),
        Described("heard", 10, "output", unit="m"),
        Described("set", 11, "output", "discrete", "Int32"),
    ),
)
WORDS = Model(
    "words",
    (
        Described("u", 1, "input", "discrete", "String", start="-", size=(2,)),
        Described("y", 3, "output", "discrete", "String", size=(2,)),
        Described("name", 5, "parameter", "fixed", "String", start="word", size=(2,)),
        Described("heard", 10, "output", unit="m"),
    ),
)
PARCEL = Model(
    "parcel",
    (
        Described("u", 1, "input", "discrete", "Binary", start="00ff", size=(2,), most=60),
        Described("y", 2, "output", "discrete", "Binary", size=(2,)),
        Described("z", 3, "output", "discrete", "Binary", size=(2,), media_type="image/png"),
        Described("sum", 10, "output", unit="m"),
        Described("size", 11, "output", "discrete", "Int32"),
        Described("set", 12, "output", "discrete", "Int32"),
        Described("first", 4, "parameter", "fixed", "Binary", start="", size=(2,), most=4),
    ),
)
FOREIGN = Model(
    "foreign",
    (
        Described("u", 1, "input", start="0", unit="m"),
        Described("kind", 2, "parameter", "fixed", "Int32", start="1"),
        Described("T", 3, "parameter", "fixed", start="0.1", unit="s"),
        Described("deaf", 4, "parameter", "fixed", start="0", unit="s"),
        Described("y", 5, "output", "discrete", unit="m/s", depends=None),
    ),
)
BALL = Model(
    "ball",
    (
        Described("h", 1, "output", unit="m"),
        Described("v", 2, "output", unit="m/s"),
        Described("der(h)", 3, "local", unit="m/s"),
        Described("der(v)", 4, "local", unit="m/s2"),
        Described("u", 5, "input", start="0", unit="m/s2"),
        Described("g", 6, "parameter", "fixed", start="9.81", unit="m/s2"),
        Described("e", 7, "parameter", "fixed", start="0.7"),
        Described("T", 8, "parameter", "fixed", start="0", unit="s"),
        Described("bounces", 9, "output", "discrete", "Int32"),
        Described("sampled", 10, "output", "discrete", unit="m"),
        Described("samples", 11, "output", "discrete", "Int32"),
        Described("steps", 12, "local", "discrete", "Int32"),
        Described("high", 13, "output", "discrete", "Boolean"),
        Described("t_end", 14, "parameter", "fixed", start="0", unit="s"),
        Described("t_wrong", 15, "parameter", "fixed", start="0", unit="s"),
        Described("again", 16, "parameter", "fixed", "Boolean", start="false"),
    ),
    states=(("h", "der(h)"), ("v", "der(v)")),
    indicators=1,
)
RELAY = Model(
    "relay",
    (
        Described("u", 1, "input", start="0", unit="m"),
        Described("K", 2, "parameter", "fixed", start="1"),
        Described("T", 3, "parameter", "fixed", start="0.02", unit="s"),
        Described("t_cross", 4, "parameter", "fixed", start="1e9", unit="s"),
        Described("y", 5, "output", "discrete", unit="m/s", depends=("u",)),
        Described("samples", 6, "output", "discrete", "Int32"),
        Described("late", 7, "output", "discrete", "Boolean"),
    ),
    states=(),
    indicators=1,
)
TRACKER = Model(
    "tracker",
    (
        Described("x", 1, "output", unit="m"),
        Described("v", 2, "output", unit="m/s"),
        Described("s", 3, "output", unit="m"),
        Described("der(x)", 4, "local", unit="m/s"),
        Described("der(v)", 5, "local", unit="m/s2"),
        Described("der(s)", 6, "local", unit="m/s"),
        Described("L", 7, "parameter", "fixed", start="1"),
        Described("near", 8, "parameter", "fixed", start="1e9", unit="s"),
        Described("t_hole", 9, "parameter", "fixed", start="1e9", unit="s"),
        Described("t_nan", 10, "parameter", "fixed", start="1e9", unit="s"),
        Described("grows", 11, "parameter", "fixed", "Boolean", start="false"),
        Described("done", 12, "local", "discrete", unit="s"),
        Described("jumps", 13, "parameter", "fixed", "Boolean", start="false"),
    ),
    states=(("x", "der(x)"), ("v", "der(v)"), ("s", "der(s)")),
)
CRASH = Model("crash", (Described("y", 1, "output", unit="s"),))
CHECKED = Model(
    "checked",
    (
        Described("u1", 1, "input", start="0.5", unit="m/s"),
        Described("u2", 2, "input", start="0"),
        Described("gain", 3, "parameter", "fixed", start="2"),
        Described("x", 4, "output", unit="m"),
        Described("y", 5, "output", unit="m/s", depends=("u1", "u2")),
        Described("z", 6, "output", depends=("u2",)),
        Described("flag", 7, "input", "discrete", "Boolean", start="false"),
    ),
    has_event_mode=True,
)
MODELS = {
    model.source: model
    for model in (
        SAMPLER,
        INTEGRATOR,
        FAULTY,
        PICKY,
        MIRROR,
        VECTOR,
        LABEL,
        WORDS,
        PARCEL,
        FOREIGN,
        BALL,
        RELAY,
        TRACKER,
        CRASH,
        CHECKED,
    )
}


def build(
    model: Model,
    fmi: int,
    folder: Path,
    *,
    variable_steps: bool = True,
    defines: tuple[str, ...] = (),
    saves: bool = False,
) -> Path:
    """Compile and pack a model for FMI 2 or 3; return the path of the FMU.

    It may claim to take equal steps only, and to save its state, in memory and as bytes.
    """
    name = model.source
    library = folder / f"{name}{fmi}{fmpy.sharedLibraryExtension}"
    sources = [str(HERE / f"{name}.c"), str(HERE / "stubs.c"), "-lm"]
    binary = ["-DBINARY"] if any(variable.type == "Binary" for variable in model.variables) else []
    exchange = ["-DEXCHANGE"] if model.states is not None else []
    saving = ["-DSAVES"] if saves else []
    defined = [
        *saving,
        *binary,
        *exchange,
        f"-DFMI={fmi}",
        f"-I{FMI_HEADERS}",
        f"-I{HERE}",
        *(f"-D{one}" for one in defines),
    ]
    subprocess.run([*_compiler(), *_CFLAGS, *defined, *sources, "-o", str(library)], check=True)
    platform = fmpy.platform if fmi == 2 else fmpy.platform_tuple
    path = folder / f"{name}{fmi}.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        text = description(model, fmi)
        if not variable_steps:
            text = text.replace('canHandleVariableCommunicationStepSize="true"', "")
        if saves:
            state = "FMUstate" if fmi == 2 else "FMUState"
            claims = f'canGetAndSet{state}="true" canSerialize{state}="true" '
            text = text.replace("<CoSimulation ", f"<CoSimulation {claims}")
            text = text.replace("<ModelExchange ", f"<ModelExchange {claims}")
        if "DIRECTIONAL" in defines:
            plural = "" if fmi == 2 else "s"
            text = text.replace("<ModelExchange ", f'<ModelExchange providesDirectionalDerivative{plural}="true" ')
        archive.writestr("modelDescription.xml", text)
        archive.write(library, f"binaries/{platform}/{name}{fmpy.sharedLibraryExtension}")
    return path


def _compiler() -> list[str]:
    cc = shutil.which("cc") or shutil.which("gcc")
    return [cc] if cc else [sys.executable, "-m", "ziglang", "cc"]


def build_first(folder: Path) -> Path:
    """Compile and pack the FMI 1.0 FMU; return its path."""
    library = folder / f"first{fmpy.sharedLibraryExtension}"
    command = [*_compiler(), *_CFLAGS, f"-I{FMI_HEADERS}", "-include", "stddef.h", str(HERE / "first.c")]
    subprocess.run([*command, "-o", str(library)], check=True)
    path = folder / "first.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.write(HERE / "first.xml", "modelDescription.xml")
        archive.write(library, f"binaries/{fmpy.platform}/first{fmpy.sharedLibraryExtension}")
    return path


def edited(fmu: Path, copy: Path, edit: Callable[[str], str]) -> Path:
    """Write a copy of an FMU with its model description edited; return its path."""
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(copy, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            new.writestr(name, edit(content.decode()) if name == "modelDescription.xml" else content)
    return copy


def with_unknown_dependencies(model: Model) -> Model:
    """Return the model without any statement of what its outputs depend on."""
    return replace(model, variables=tuple(replace(variable, depends=None) for variable in model.variables))


def description(model: Model, fmi: int) -> str:
    """Return the modelDescription.xml."""
    return _description2(model) if fmi == 2 else _description3(model)


def _attributes(variable: Described, *names: str) -> str:
    values = {name: getattr(variable, name) for name in names}
    return " ".join(f'{name}="{value}"' for name, value in values.items() if value is not None)


def _units(model: Model) -> str:
    units = sorted({variable.unit for variable in model.variables if variable.unit})
    return "".join(f'<Unit name="{unit}"/>' for unit in units)


def _items(model: Model) -> str:
    return "".join(f'<Item name="{name}" value="{i}"/>' for i, name in enumerate(model.literals, 1))


def _interface(model: Model, fmi: int) -> str:
    if model.states is not None:
        step = "" if fmi == 2 else ' needsCompletedIntegratorStep="true"'
        return f'<ModelExchange modelIdentifier="{model.source}"{step}/>'
    steps = 'canHandleVariableCommunicationStepSize="true"'
    event_mode = ' hasEventMode="true"' if model.has_event_mode and fmi == 3 else ""
    return f'<CoSimulation modelIdentifier="{model.source}" {steps}{event_mode}/>'


def _description3(model: Model) -> str:
    types = f'<EnumerationType name="Choice">{_items(model)}</EnumerationType>'
    lines = []
    for v in model.variables:
        declared = ' declaredType="Choice"' if v.type == "Enumeration" else ""
        opaque = v.type in ("String", "Binary")
        attributes = _attributes(v, "name", "causality", "variability", *(() if opaque else ("start",)), "unit")
        attributes += f' mimeType="{v.media_type}"' if v.media_type else ""
        attributes += f' maxSize="{v.most}"' if v.most else ""
        inner = "".join(f'<Dimension start="{size}"/>' for size in v.size)
        inner += f'<Start value="{v.start}"/>' * (v.size or (1,))[0] if opaque and v.start is not None else ""
        lines.append(f'<{v.type} valueReference="{v.reference}" {attributes}{declared}>{inner}</{v.type}>')
    outputs, unknowns = [], []
    references = {v.name: str(v.reference) for v in model.variables}
    for v in model.variables:
        if v.causality == "output":
            known = "" if v.depends is None else f' dependencies="{" ".join(references[n] for n in v.depends)}"'
            outputs.append(f'<Output valueReference="{v.reference}"{known}/>')
            unknowns.append(f'<InitialUnknown valueReference="{v.reference}"{known}/>')
    for state, derivative in model.states or ():
        known = f'valueReference="{references[derivative]}" dependencies=""'
        outputs.append(f"<ContinuousStateDerivative {known}/>")
        unknowns.append(f"<InitialUnknown {known}/>")
        mark = f'valueReference="{references[derivative]}" '
        lines = [line.replace(mark, f'{mark}derivative="{references[state]}" ') for line in lines]
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="{model.source}" instantiationToken="test" generationTool="cosim tests">
  {_interface(model, 3)}
  <UnitDefinitions>{_units(model)}</UnitDefinitions>
  {f"<TypeDefinitions>{types}</TypeDefinitions>" if model.literals else ""}
  <ModelVariables><Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
  {"".join(lines)}</ModelVariables>
  <ModelStructure>{"".join(outputs + unknowns)}</ModelStructure>
</fmiModelDescription>"""


def _description2(model: Model) -> str:
    types = f'<SimpleType name="Choice"><Enumeration>{_items(model)}</Enumeration></SimpleType>'
    lines = []
    for v in model.variables:
        kind = _FMI2_TYPES.get(v.type, v.type)
        declared = 'declaredType="Choice" ' if v.type == "Enumeration" else ""
        outer = _attributes(v, "name", "causality", "variability")
        value = f"<{kind} {declared}{_attributes(v, 'start', 'unit')}/>"
        lines.append(f'<ScalarVariable valueReference="{v.reference}" {outer}>{value}</ScalarVariable>')
    unknowns = []
    positions = {v.name: str(i) for i, v in enumerate(model.variables, 1)}
    for v in model.variables:
        if v.causality == "output":
            known = "" if v.depends is None else f' dependencies="{" ".join(positions[n] for n in v.depends)}"'
            unknowns.append(f'<Unknown index="{positions[v.name]}"{known}/>')
    states = model.states or ()
    derivatives = [f'<Unknown index="{positions[derivative]}" dependencies=""/>' for _, derivative in states]
    for state, derivative in states:
        index = int(positions[derivative]) - 1
        lines[index] = lines[index].replace("<Real", f'<Real derivative="{positions[state]}"')
    listed = f"<Derivatives>{''.join(derivatives)}</Derivatives>" if derivatives else ""
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="{model.source}" guid="test" generationTool="cosim tests"
  {f'numberOfEventIndicators="{model.indicators}"' if model.states is not None else ""}>
  {_interface(model, 2)}
  <UnitDefinitions>{_units(model)}</UnitDefinitions>
  {f"<TypeDefinitions>{types}</TypeDefinitions>" if model.literals else ""}
  <ModelVariables>{"".join(lines)}</ModelVariables>
  <ModelStructure>
    <Outputs>{"".join(unknowns)}</Outputs>{listed}
    <InitialUnknowns>{"".join(unknowns + derivatives)}</InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>"""

"""Rules that run the binary; they are applied in a process of their own, once for each interface."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence

from fmpy.model_description import ModelVariable

from cosim.check._bench import STEPS, Bench, Value, is_real
from cosim.check._rules import Found, Rules, Severity, shortened
from cosim.check._subject import place

RUN_RULES: Rules[Bench] = Rules()
Row = Mapping[str, Sequence[Value]]
_TELL = "tell whoever exported the FMU"


def same(one: Value, other: Value) -> bool:
    """Tell whether two values are the same, two NaN being so."""
    return one == other or (one != one and other != other)  # noqa: PLR0124 - NaN


def differences(one: Sequence[Row], other: Sequence[Row]) -> dict[str, int]:
    """Return the names of variables whose values differ in two runs, with the first row where they do."""
    found: dict[str, int] = {}
    for k, (row, row_there) in enumerate(zip(one, other, strict=True)):
        for name, values in row.items():
            if name not in found and not all(map(same, values, row_there[name])):
                found[name] = k
    return found


def _without_counters(bench: Bench, found: Mapping[str, int]) -> dict[str, int]:
    """Leave out locals that are whole numbers: these may count calls, which a state need not remember."""
    counters = {v.name for v in bench.compared if v.causality == "local" and "Int" in v.type}
    return {name: k for name, k in found.items() if name not in counters}


def _told(found: Mapping[str, int]) -> str:
    first = min(found.values())
    return f"{shortened(list(found), 3)}, first after step {first + 1}"


@RUN_RULES("run", Severity.ERROR)
def run(bench: Bench) -> Iterator[Found]:
    """The FMU can be instantiated, initialised, stepped, terminated and freed with its start values."""
    with bench.instance() as instance:
        instance.initialize()
        rows = instance.run()
        instance.terminate()
    outputs = [v.name for v in bench.compared if v.causality == "output" and is_real(v)]
    bad = [name for name in outputs if not all(math.isfinite(float(value)) for row in rows for value in row[name])]
    if bad:
        yield Found(f"outputs that are no finite numbers: {shortened(bad)}", "", _TELL)


@RUN_RULES("run.version", Severity.ERROR)
def version(bench: Bench) -> Iterator[Found]:
    """The binary tells the version of FMI that the model description has."""
    expected = bench.subject.description.fmiVersion
    with bench.instance() as instance:
        told = instance.version()
    if told.split(".")[0] != expected.split(".")[0]:
        yield Found(f"fmi{bench.subject.fmi}GetVersion tells {told!r}, the description {expected!r}", "", _TELL)


@RUN_RULES("run.token", Severity.WARNING)
def token(bench: Bench) -> Iterator[Found]:
    """An instance is refused if the guid or instantiationToken is not that of the description."""
    try:
        with bench.instance(token="not this one"):
            pass
    except Exception:
        return
    yield Found("instantiates with a wrong token, so a description of another model would do", "", _TELL)


@RUN_RULES("run.start", Severity.ERROR)
def start(bench: Bench) -> Iterator[Found]:
    """Start values in the model description (initial = exact) are those that the binary returns in initialisation."""
    known = [
        v
        for v in bench.compared
        if v.start is not None
        and (v.initial == "exact" or v.causality in ("input", "parameter", "structuralParameter"))
    ]
    with bench.instance() as instance:
        instance.enter_initialization()
        values = instance.values(known)
        instance.exit_initialization()
    for variable in known:
        told = _starts(variable, len(values[variable.name]))
        wrong = [(a, b) for a, b in zip(told, values[variable.name], strict=True) if not _close(a, b, variable.type)]
        if wrong:
            text, value = wrong[0]
            shown = value.decode("utf-8", "replace") if isinstance(value, bytes) else value
            yield Found(f"starts at {text} in the description, at {shown} in the binary", place(variable), _TELL)


def _starts(variable: ModelVariable, count: int) -> list[str]:
    if variable.type == "String":
        return [str(variable.start)] * count
    tokens = str(variable.start).split()
    return tokens if len(tokens) == count else tokens[:1] * count


def _close(text: str, value: Value, kind: str) -> bool:
    if kind == "String":
        return text == (value.decode("utf-8", "replace") if isinstance(value, bytes) else value)
    if kind == "Boolean":
        return (text in ("true", "1")) == bool(value)
    if kind in ("Real", "Float64", "Float32"):
        return same(float(text), float(value)) or math.isclose(
            float(text), float(value), rel_tol=1e-6 if kind == "Float32" else 1e-14
        )
    return int(text) == int(value)


@RUN_RULES("run.repeat", Severity.WARNING, instances=2)
def repeat(bench: Bench) -> Iterator[Found]:
    """Two runs of new instances give the same numbers, to the last bit."""
    runs = []
    for _ in range(2):
        with bench.instance() as instance:
            instance.initialize()
            runs.append(instance.run())
    if found := differences(*runs):
        yield Found(f"differ in a second run: {_told(found)}", "", _TELL)


@RUN_RULES("run.reset", Severity.WARNING)
def reset(bench: Bench) -> Iterator[Found]:
    """A run after a reset gives the same numbers as that before."""
    with bench.instance() as instance:
        instance.initialize()
        before = instance.run()
        instance.reset()
        instance.initialize()
        after = instance.run()
    if found := differences(before, after):
        yield Found(f"differ after a reset: {_told(found)}", "", _TELL)


@RUN_RULES("run.state", Severity.ERROR)
def state(bench: Bench) -> Iterator[Found]:
    """A state that was saved and set again gives the same steps again, if canGetAndSetFMUState is claimed."""
    if not bench.claims("canGetAndSetFMUstate"):
        return
    with bench.instance() as instance:
        instance.initialize()
        instance.run(STEPS // 3)
        saved = instance.state()
        before = instance.run(STEPS // 3, first=STEPS // 3)
        instance.restore(saved)
        after = instance.run(STEPS // 3, first=STEPS // 3)
        instance.forget(saved)
    if found := _without_counters(bench, differences(before, after)):
        yield Found(f"are not restored with the state: {_told(found)}", "", _TELL)


@RUN_RULES("run.serialize", Severity.ERROR, instances=2)
def serialize(bench: Bench) -> Iterator[Found]:
    """A state that was serialized gives the same steps in a new instance, if canSerializeFMUState is claimed."""
    if not bench.claims("canSerializeFMUstate"):
        return
    with bench.instance() as instance:
        instance.initialize()
        instance.run(STEPS // 3)
        saved = instance.state()
        content = instance.serialized(saved)
        instance.forget(saved)
        before = instance.run(STEPS // 3, first=STEPS // 3)
    with bench.instance() as instance:
        instance.initialize()
        loaded = instance.deserialized(content)
        instance.restore(loaded)
        instance.forget(loaded)
        after = instance.run(STEPS // 3, first=STEPS // 3)
    if found := _without_counters(bench, differences(before, after)):
        yield Found(f"are not restored from bytes: {_told(found)}", "", _TELL)


@RUN_RULES("run.variable-steps", Severity.ERROR)
def variable_steps(bench: Bench) -> Iterator[Found]:
    """Steps of changing length succeed, if canHandleVariableCommunicationStepSize is claimed."""
    if not (bench.is_cs and bench.claims("canHandleVariableCommunicationStepSize")):
        return
    with bench.instance() as instance:
        instance.initialize()
        ends = list(itertools.accumulate((1.0, 0.5, 1.7, 0.013, 1.0, 0.29), initial=0.0))
        for k, (begin, end) in enumerate(itertools.pairwise(ends), 1):
            t = bench.start + begin * bench.step
            try:
                instance.advance(t, bench.start + end * bench.step - t)
            except Exception as error:
                text = f"step {k} of changing length, {(end - begin) * bench.step:g} s, fails: {error}"
                yield Found(f"{text}; {instance.log}", "", "do not claim canHandleVariableCommunicationStepSize")
                return


@RUN_RULES("run.event-mode", Severity.ERROR)
def event_mode(bench: Bench) -> Iterator[Found]:
    """Event Mode can be entered and left, and its iteration ends, if hasEventMode is claimed."""
    if not (bench.is_cs and bench.claims("hasEventMode")):
        return
    t = bench.start
    with bench.instance(event_mode=True) as instance:
        try:
            instance.initialize()
            for _ in range(STEPS):
                h = min(bench.step, max(instance.next_event - t, 0.0)) or bench.step
                instance.advance(t, h)
                t += h
        except Exception as error:
            yield Found(f"with Event Mode at {t:g} s: {error}; {instance.log}", "", _TELL)


@RUN_RULES("run.counts", Severity.ERROR)
def counts(bench: Bench) -> Iterator[Found]:
    """The binary has as many continuous states and event indicators as the description, and nominals above 0."""
    if bench.is_cs:
        return
    description = bench.subject.description
    expected = (description.numberOfContinuousStates, int(description.numberOfEventIndicators or 0))
    with bench.instance() as instance:
        instance.initialize()
        told = instance.counts() if bench.subject.fmi == 3 else expected
        nominals = instance.nominals() if told[0] == expected[0] else []
        if told == expected:
            instance.derivatives()  # the FMU may refuse a wrong number
            instance.indicators()
    if expected[1] == 0:
        told = told[0], 0  # FMI 3.0 leaves it open whether event indicators are listed
    for name, here, there in zip(("continuous states", "event indicators"), expected, told, strict=True):
        if here != there:
            yield Found(f"the description has {here} {name}, the binary {there}", "ModelStructure", _TELL)
    if wrong := [value for value in nominals if not value > 0.0]:
        yield Found(f"a nominal value of a continuous state is {wrong[0]:g}", "", _TELL)


@RUN_RULES("run.derivatives", Severity.ERROR)
def derivatives(bench: Bench) -> Iterator[Found]:
    """Derivatives of outputs can be got if maxOutputDerivativeOrder is above 0, those of inputs set if claimed."""
    if not bench.is_cs:
        return
    outputs, inputs = bench.reals("output"), bench.reals("input")
    with bench.instance() as instance:
        instance.initialize()
        instance.advance(bench.start, bench.step)
        try:
            if outputs and bench.subject.number(bench.interface, "maxOutputDerivativeOrder") > 0:
                values = instance.output_derivatives(outputs)
                bad = [v.name for v, value in zip(outputs, values, strict=True) if not math.isfinite(value)]
                if bad:
                    yield Found(f"derivatives of outputs that are no finite numbers: {shortened(bad)}", "", _TELL)
            if inputs and bench.subject.fmi == 2 and bench.claims("canInterpolateInputs"):
                instance.set_input_derivatives(inputs)
        except Exception as error:
            yield Found(f"{error}; {instance.log}", "", "correct what is claimed")

"""What a user reads about a wrong model: file, line, what is wrong, what to do; never a traceback."""

from __future__ import annotations

import re
import string
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from cosim.errors import ModelError
from cosim.fmu import compile_model
from cosim.modelica import Source, flatten

pytest.importorskip("rumoca")

BAD = Path(__file__).parents[1] / "models" / "bad"
UNITS = (
    "accepted are SI symbols with prefixes and bare exponents, joined by '.' and '/', such as N.m, kg.m2, rad/s,"
    " V.s/rad, m/s2, Ohm, ms, deg, rpm, degC, % or 1 for a plain number"
)
MESSAGES = {
    "Algorithm": "6:3: Algorithm: a while-loop cannot depend on variables; put it into a function, with a"
    " number of turns that is known",
    "ArgumentShape": "3:16: ArgumentShape: `v` gets an argument of the wrong size: dimension 1 has 3 elements"
    " instead of 2",
    "AssertInIf": "6:5: assert inside an if-equation is not supported; put the condition c of the if into it,"
    " as assert(condition or not c, ...), and take it out",
    "BranchesDiffer": "6:3: BranchesDiffer: every branch of an if-equation must have the same number of"
    " equations, and there must be an else",
    "Break": "2:12: Break: `summed` has a loop that the front end cannot follow: a while-loop, break, or for"
    " over the elements of an array; use for i in 1:n and if inside",
    "Clocked": "5:9: Clocked: previous is not supported: clocks do not exist here; use when sample(start,"
    " interval) and pre()",
    "ConnectInIf": "12:5: connect inside an if-equation is not supported; make one of the components"
    " conditional instead, as in: Component c if condition",
    "ConnectedSources": "10:5: ConnectedSources is structurally singular: for first.p.i, second.p.i there is"
    " only 1 equation: 0 = first.p.i + second.p.i (ConnectedSources.mo:4); for first.p.v, second.p.v alone there are"
    " 3 equations: first.p.v = first.u (ConnectedSources.mo:10), second.p.v = second.u (ConnectedSources.mo:10),"
    " first.p.v = second.p.v (ConnectedSources.mo:3)",
    "ConstrainedInput": "7:3: x ^ 3 = u: the derivative of the input u would be needed here; an input cannot"
    " prescribe what is a state of the model. Prescribe a force, torque or voltage instead, or pass the input"
    " through a filter",
    "ConstrainedModifier": "9:35: the front end loses the modifiers after constrainedby of a class; give them"
    " where the class is used",
    "Delay": "4:13: delay() is not supported: the past of a variable is not kept; sample it, or describe the"
    " delay with states",
    "DiscreteLoop": "3:11: DiscreteLoop: `a` needs its own new value to be computed; use pre() to break the ring",
    "EndlessLoop": "2:12: EndlessLoop: `rounded` has a loop that the front end cannot follow: a while-loop,"
    " break, or for over the elements of an array; use for i in 1:n and if inside",
    "EqualReals": "1:7: EqualReals: equality comparison on Real values is not allowed outside functions (MLS §3.5)",
    "EquationTooMany": "4:3: EquationTooMany has 2 equations for 1 unknown: for x alone there are 2 equations:"
    " der(x) = -x (EquationTooMany.mo:4), x = 2 (EquationTooMany.mo:5)",
    "ExternalFunction": "2:12: the function cubicRoot is external; functions in C or Fortran are not"
    " supported, only Modelica algorithms",
    "ExternalTable": "5:20: ExternalTable: `Table.t` is of type `Table`: variables of functions can be"
    " numbers, Booleans, enumerations and records; objects outside Modelica do not exist here",
    "FalseAssertion": "6:5: an assertion is violated: root of a negative number",
    "ForbiddenState": "3:3: y has StateSelect.always but cannot be a state together with the others; its"
    " constraints leave no freedom for it",
    "FreeParameter": "2:13: the parameter p has fixed=false, but initial equations cannot find parameters"
    " here; give it a value",
    "InitialDiscrete": "5:9: x is not a parameter, so it cannot stand in a parameter's value or a start",
    "InitialState": "2:8: InitialState: an initial algorithm can give values to discrete variables and to"
    " parameters with fixed=false, but not to `x`; write an initial equation",
    "InputDerivative": "5:10: y equals the input x, whose derivative would be needed; pass the input through a filter",
    "LostModifier": "15:17: the front end loses the modifiers in redeclare model Part = ...(...); declare a"
    " class with them, such as model T = ...(...), and write redeclare model Part = T",
    "Message": '6:22: if loud then "LOW" else "low": a message can be made of literals, String parameters,'
    " String(x) and +",
    "MissingEquation": "2:3: MissingEquation has 1 equation for 2 unknowns: for x, force there is only 1"
    " equation: der(x) = -x + force (MissingEquation.mo:5)",
    "MixedSection": "7:8: this algorithm section assigns a variable inside when and uses it outside, or the"
    " other way round; put the when-statement into an algorithm section of its own",
    "NoUnit": f"2:3: x: 'grumble/s' is not a unit; {UNITS}",
    "NoValue": "2:13: the parameter k has no value; give it one",
    "OrderInWhen": "7:5: v is assigned in this when-clause, and its new value used; where elements of arrays"
    " are assigned, too, write an algorithm section, in which the order counts",
    "OutOfRange": "5:16: OutOfRange: subscript 4 for `x` is out of bounds for dimension of size 3 (MLS §10.5.1)",
    "OuterWithoutInner": "2:14: OuterWithoutInner: the outer `ambient` has no inner: declare one of that name"
    " around it",
    "Overconstrained": "18:3: Connections.root, branch and potentialRoot are not supported: connectors may not"
    " be overconstrained; give orientations by angles",
    "RealToInteger": "6:3: n is of type Integer, but 2.5 * time is of type Real; use integer() to round it down",
    "Recursion": "6:34: Recursion.factorial calls itself; functions that call themselves are not supported,"
    " use a for-loop",
    "RedeclaredInherited": "21:13: the front end loses the redeclaration of c, which E has inherited; extend the class"
    " that declares c, or redeclare it where E is a component",
    "RedeclaredPackage": "16:12: redeclared packages are not supported: the front end mixes up their"
    " constants; give the constants as parameters",
    "ReinitAlgebraic": "3:8: ReinitAlgebraic: reinit() of `y`, which is not a state: only what stands in der()"
    " can be reinitialised",
    "Ring": "2:18: Ring: cyclic dependency in parameter binding for 'a': parameters depend on each other in a ring",
    "Singular": "7:3: Singular is structurally singular: for b, c there is only 1 equation: b + c = x"
    " (Singular.mo:10); for x, a alone there are 3 equations: der(x) = -x (Singular.mo:7), a = 2 * x"
    " (Singular.mo:8), a = 3 * x + 1 (Singular.mo:9)",
    "SpatialDistribution": "5:12: SpatialDistribution: spatialDistribution is not supported: transport delays"
    " keep no past here; divide the length into cells, with an equation each",
    "StateMachine": "10:3: StateMachine: initialState is not supported: state machines of Modelica 3.3 do not"
    " exist here; use an enumeration and when-clauses",
    "Stream": "5:12: port.h is a stream variable; connectors with stream variables are not supported, only"
    " potential and flow variables",
    "SyntaxError": "3:1: unexpected `equation`; expected one of: annotation, constrainedby, ;, ), ,",
    "Terminal": "4:10: terminal() can stand only in a when-condition",
    "Text": "3:3: name: a String can be a parameter or constant, for messages; variables cannot",
    "ThreeDimensions": "2:3: t: arrays have at most two dimensions here",
    "TooManyStarts": "3:3: TooManyStarts: one initial condition too many: these 2 determine only x: x = 1"
    " (fixed start) (TooManyStarts.mo:2), y = 2 (fixed start) (TooManyStarts.mo:3). Take fixed=true or an initial"
    " equation away",
    "TwoStarts": "3:3: y and x are the same variable but have different fixed start values",
    "UnassignedDiscrete": "3:3: b is discrete, but no equation or when-clause gives it a value",
    "UndefinedLocal": "1:7: UndefinedLocal: a function uses a variable that has no value yet, or ends without"
    " giving its output one",
    "UndefinedResult": "12:13: positive(x): positive does not give y a value in every case",
    "UnknownClass": "3:3: UnknownClass: unresolved type reference: 'Gearbox'",
    "UnknownParameter": "8:11: UnknownParameter: unknown modifier `tau` for component `lag` of type `Lag`",
    "UnknownVariable": "4:17: UnknownVariable: unresolved component reference: 'spede'",
    "WhenInIf": "7:5: when inside an if-equation is not supported; put the condition c of the if into it, as"
    " when c and condition then, and take it out",
    "WrongEnd": "5:5: parse error: End name 'RightEnd' does not match class name",
    "WrongShape": "5:3: WrongShape: array dimension mismatch: expected `[3]`, found `[2]`",
}


def test_every_wrong_model_has_its_message() -> None:
    assert set(MESSAGES) == {file.stem for file in BAD.glob("*.mo")}


@pytest.mark.filterwarnings("ignore::cosim.errors.ModelWarning")
@pytest.mark.parametrize("name", sorted(MESSAGES))
def test_a_wrong_model_is_refused_with_its_place_and_what_to_do(name: str) -> None:
    file = BAD / f"{name}.mo"
    with pytest.raises(ModelError) as caught:
        compile_model(file, name)
    assert str(caught.value) == f"{file}:{MESSAGES[name]}"
    assert caught.value.exit_code == 2


def test_a_class_that_is_not_there_is_named() -> None:
    file = BAD / "Delay.mo"
    with pytest.raises(ModelError) as caught:
        compile_model(file, "Delayed")
    expected = (
        f"{file}: there is no class 'Delayed' in this text, did you mean 'Delay'?; give its full name, package and all"
    )
    assert str(caught.value) == expected


def test_a_partial_model_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "Base.mo"
    file.write_text('partial model Base "Base"\n  Real x(start=1, fixed=true);\nequation\n  der(x) = -x;\nend Base;\n')
    with pytest.raises(ModelError) as caught:
        compile_model(file, "Base")
    assert str(caught.value) == f"{file}:1:15: Base is partial, a basis for other models; compile one that extends it"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"\xff\xfe\x00", ": Modelica text is UTF-8; byte 0 is not"),
        (b"", ": there is no class 'M' in this text; give its full name, package and all"),
    ],
)
def test_a_file_without_modelica_text_is_refused(tmp_path: Path, content: bytes, message: str) -> None:
    file = tmp_path / "M.mo"
    file.write_bytes(content)
    with pytest.raises(ModelError) as caught:
        compile_model(file, "M")
    assert str(caught.value) == f"{file}{message}"


def test_missing_files_and_folders_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ModelError) as caught:
        Source.read(tmp_path / "none.mo")
    assert str(caught.value) == (
        f"{tmp_path / 'none.mo'}: no such file or folder; give a .mo file or a folder with a package.mo"
    )
    with pytest.raises(ModelError) as caught:
        Source.read(tmp_path)
    assert str(caught.value) == f"{tmp_path}: this folder has no package.mo, so it is not a Modelica package"


def test_the_place_is_right_in_the_file_of_a_package_folder(tmp_path: Path) -> None:
    folder = tmp_path / "Lib"
    folder.mkdir()
    (folder / "package.mo").write_text('package Lib "Päckchen"\nend Lib;\n', encoding="utf-8")
    (folder / "A.mo").write_text('within Lib;\nmodel A "Größe"\n  Real x = 1;\nend A;\n', encoding="utf-8")
    (folder / "B.mo").write_text('within Lib;\n// Maß\nmodel B "Weiß"\n  Real x = ß;\nend B;\n', encoding="utf-8")
    with pytest.raises(ModelError) as caught:
        flatten(Source.read(folder), "Lib.A")
    assert (caught.value.file, caught.value.line) == (folder / "B.mo", 4)
    (folder / "B.mo").write_text('within Lib;\n// Maß\nmodel B "Weiß"\n  Real x = y;\nend B;\n', encoding="utf-8")
    with pytest.raises(ModelError) as caught:
        flatten(Source.read(folder), "Lib.B")
    assert str(caught.value) == f"{folder / 'B.mo'}:4:12: Lib.B: unresolved component reference: 'y'"


WORDS = [
    "model", "M", "end", "equation", "Real", "x", "y", "(", ")", "=", ";", "der", "+", "-", "*", "/", "1", "2.5", "if",
    "then", "else", "when", "pre", "sample", ",", "[", "]", "{", "}", ":", '"text"', "parameter", "input", "start",
    "connect", "algorithm", ":=", "time", "sin", "Boolean", "and", "not", "<", "//", "/*", "each", "for", "loop", "in",
    "initial", "within", "package", "extends", "reinit", ".", "annotation", "ä", "\n", "'", "\\", "0x", "1e999", "$",
]  # fmt: skip


def refuse_or_compile(tmp_path: Path, text: str) -> None:
    file = tmp_path / "M.mo"
    file.write_text(text, encoding="utf-8")
    try:
        compile_model(file, "M")
    except ModelError as error:
        assert str(error).startswith(str(file)), error


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.sampled_from(WORDS), max_size=25))
def test_any_words_in_a_model_give_a_message_never_a_traceback(tmp_path: Path, words: list[str]) -> None:
    refuse_or_compile(tmp_path, f"model M\n {' '.join(words)} \nend M;")


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.text(alphabet=string.printable + "äß→\u2028\U0001f600", max_size=60))
def test_any_text_gives_a_message_never_a_traceback(tmp_path: Path, text: str) -> None:
    refuse_or_compile(tmp_path, text)


DECLARATIONS = {
    "x": "Real x(start=1, fixed=true);",
    "y": "Real y;",
    "k": "parameter Real k = 2;",
    "b": "Boolean b;",
    "n": "Integer n(start=0);",
    "a": "Real a[2];",
}
EQUATIONS = """
der(x) = -k*x;
y = 2*x;
y = x^2 + n;
b = x < 0.5;
when b then n = pre(n) + 1; end when;
when sample(0, 0.1) then n = pre(n) + 1; end when;
a = {x, y};
a[1] = x; a[2] = a[1];
y = der(x);
x = time;
y = if b then 1 else x;
der(y) = x;
b = not b;
b = pre(b);
when x > 1 then reinit(x, 0); end when;
y = a[3];
a = x;
y = b;
n = x;
y = sqrt(a);
y = max(x, k, 3);
y = smooth(0, x);
y = mod(x, 0.1);
y = integer(x);
assert(x > 0, "text");
terminate("end");
for i in 1:2 loop a[i] = i*x; end for;
x = y; y = x;
0 = y*x;
y = sample(0, 1);
y = a*a;
y = pre(x);
k = 3;
y = time/0;
y = atan2(x);
y = cat(1, a);
der(k) = 1;
y = {1, 2}*a;
der(b) = 1;
a = a + y;
y = noEvent(abs(x));
y = der(x); der(y) = -x;
y = der(x); a[1] = der(y); der(a[1]) = a[2]; a[2] = -x - y - a[1];
""".strip().splitlines()


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.sampled_from(EQUATIONS), min_size=1, max_size=5))
@example(["0 = y*x;", "y = time/0;"])  # an infinite coefficient
def test_any_equations_give_a_model_or_a_message(tmp_path: Path, equations: list[str]) -> None:
    names = set(re.findall(r"\w+", " ".join(equations)))
    declarations = [text for name, text in DECLARATIONS.items() if name in names]
    refuse_or_compile(tmp_path, f"model M\n  {' '.join(declarations)}\nequation\n  {' '.join(equations)}\nend M;\n")

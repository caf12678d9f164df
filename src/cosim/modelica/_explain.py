"""What the front end says when it refuses a model, in the terms of the person who wrote it, with the place."""

from __future__ import annotations

import re

from cosim.errors import ModelError
from cosim.modelica._scan import scan
from cosim.modelica.source import Source

AT = re.compile(r"\s*\[[^\]\s]*:(\d+):(\d+)\]")
"""Line and column in a message of the front end."""
_QUOTED = re.compile(r"[`']([A-Za-z_][\w.]*)(?:\[[^\]]*\])?[`']")


def offset(source: Source, line: int, column: int) -> int:
    """Byte offset of a line and column, both counted from 1."""
    lines = source.text.split("\n")
    return len("\n".join(lines[: line - 1]).encode()) + (line > 1) + len(lines[line - 1][: column - 1].encode())


def explain(source: Source, model: str, text: str) -> ModelError:
    """The error for a message of the front end: put plainly, and the place in front that it leaves out.

    Args:
        source: the text.
        model: the full name of the class that was asked for.
        text: the front end's message.
    """
    message = text.partition("\nRelated failures")[0].strip().removeprefix(f"{model} ")
    message = re.sub(r"^(could not be compiled: |(todae|flatten|instantiate|typecheck) failed: )", "", message)
    message = re.sub(r"\S+ failed in \w+: ", "", message)
    declared = source.find_class(model)
    for word, remedy in _FEATURES.items():
        if re.search(rf"\b{word}\b", message) and (found := source.find(word)) is not None:
            return source.error(f"{model}: {word} is not supported: {remedy}", found)
    place: int | None = None
    for pattern, plainer, what in _PLAINER:
        match = re.search(pattern, message, re.DOTALL)
        if match is not None:
            if what:
                place = _first(source, what, declared or 0)
            message = message[: match.start()] + match.expand(plainer) + message[match.end() :]
    at = AT.search(message)
    if at is not None:
        return source.error(f"{model}: {AT.sub('', message)}", offset(source, int(at.group(1)), int(at.group(2))))
    if place is None:
        place = _quoted(source, message, declared)
    return source.error(f"{model}: {message}", place)


def _quoted(source: Source, message: str, declared: int | None) -> int | None:
    """Where the first name that a message quotes is used."""
    for name in _QUOTED.findall(message):
        for after in (declared or 0, 0):
            found = source.find(name.rpartition(".")[2], after=after)
            if found is not None:
                return found
    return declared


def _first(source: Source, what: str, after: int) -> int | None:
    """Where the first algorithm section, or if-equation, of a class that is no function begins."""
    found = scan(source.text)
    places = [s.at for s in found.statements if s.kind == what and s.class_kind != "function"]
    return next((at for at in (*(p for p in places if p >= after), *places)), None)


_FEATURES = {
    "spatialDistribution": "transport delays keep no past here; divide the length into cells, with an equation each",
    "previous": "clocks do not exist here; use when sample(start, interval) and pre()",
    "initialState": "state machines of Modelica 3.3 do not exist here; use an enumeration and when-clauses",
    "transition": "state machines of Modelica 3.3 do not exist here; use an enumeration and when-clauses",
    "ExternalObject": "objects outside Modelica do not exist here; give tables as parameters",
    "getInstanceName": "names of instances are not known here; write the text out",
    "cardinality": "connections cannot be counted here; use a parameter and conditional components",
}
"""Parts of the language that the front end names in its message, and what to do without them."""

_PLAINER = (
    (r"unsupported model algorithm in canonical DAE: (.*)",
     r"this algorithm section is beyond what the front end can take: \1; write equations, or put the statements into a"
     r" function and call it", "algorithm"),
    (r"event-generating expressions are not allowed in while-statement conditions or bodies.*",
     "a while-loop cannot depend on variables; put it into a function, with a number of turns that is known", "while"),
    (r"unsupported initial algorithm in canonical DAE: initial algorithm target (`.*?`) .*",
     r"an initial algorithm can give values to discrete variables and to parameters with fixed=false, but not to \1;"
     r" write an initial equation", ""),
    (r"unsupported Flat semantic owner `function (?:loop reduction|loop domain|statement)`: (`.*?`) .*",
     r"\1 has a loop that the front end cannot follow: a while-loop, break, or for over the elements of an array; use"
     r" for i in 1:n and if inside", ""),
    (r"unsupported Flat semantic owner `function shape proof`: (`.*?`): axis (\d+) requires extent (\d+) but the call"
     r" site proves (\d+)", r"\1 gets an argument of the wrong size: dimension \2 has \4 elements instead of \3", ""),
    (r"unsupported Flat semantic owner `function value type`: (`.*?`) has unsupported type (`.*?`)",
     r"\1 is of type \2: variables of functions can be numbers, Booleans, enumerations and records; objects outside"
     r" Modelica do not exist here", ""),
    (r"unsupported equation form: if-equation branches have mismatched equation counts.*",
     "every branch of an if-equation must have the same number of equations, and there must be an else", "if"),
    (r"unsupported equation form: for-equation range must be a constant range.*",
     "a for-loop over equations needs a range first:last or first:step:last of constants and parameters", "for"),
    (r"unsupported equation form: when-equation LHS must be a simple variable reference.*",
     "on the left of an equation inside when there must be one variable", "when"),
    (r"unsupported equation form: ", "", ""),
    (r"unsupported Flat semantic owner `when assignment`: (`(\w+)[^`]*`) is not a discrete coordinate.*",
     r"\1 is an element of an array, and inside when only whole variables can be assigned; write \2 = {...}", "when"),
    (r"unsupported Flat semantic owner `when function-call outputs`.*",
     "a function with several outputs cannot be called inside when; call it once for each", "when"),
    (r"canonical DAE construction rejected an invalid operation: missing function value definition.*",
     "a function uses a variable that has no value yet, or ends without giving its output one", ""),
    (r"canonical DAE construction rejected an invalid operation: duplicate reinitialization owner definition.*",
     "a state is reinitialised by more than one when-clause; put them into one, with elsewhen", "reinit"),
    (r"canonical DAE construction rejected an invalid operation: expression type mismatch: expected Real, found"
     r" Integer",
     "an Integer stands where only a Real can; write 1.0 instead of 1", ""),
    (r"^requires inner declarations: (\w+)", r"the outer `\1` has no inner: declare one of that name around it", ""),
    (r"unevaluable array dimensions for ('.*?'): .*",
     r"the size of \1 must follow from literals and parameters, without a function", ""),
    (r"unsupported runtime operator (`.*?`): no checked canonical owner.*", r"the front end does not know \1()", ""),
    (r"^missing source scope for imports:.*",
     "the front end cannot take this; a frequent cause is an output that is left out, as in (, b) = function()", ""),
    (r"unbalanced model: (\d+) equations, (\d+) unknowns.*",
     r"the model has \1 equation(s) for \2 unknown(s); add what is missing or remove what is too many", ""),
    (r"invalid Appendix B discrete solved form: (`.*?`) participates in an? (internal )?current-value dependency cycle",
     r"\1 needs its own new value to be computed; use pre() to break the ring", ""),
    (r"invalid Appendix B discrete solved form: (`.*?`) has more than one semantic definition owner",
     r"\1 is defined more than once", ""),
    (r"unsupported Flat semantic owner `pre expression`: pre\((`.*?`)\) .*",
     r"pre() of \1: a continuous variable has a value before the event only inside when", ""),
    (r"canonical DAE construction rejected an invalid operation: expected a numeric expression, found (\w+)",
     r"a value of type \1 stands where a number is expected", ""),
    (r"canonical DAE construction rejected an invalid operation: expression shape mismatch",
     "the two sides of an equation do not fit: arrays of different shapes, or a Real for an Integer", ""),
    (r"reinit\(\) can only be applied to state variables: (\S+) is not a state",
     r"reinit() of `\1`, which is not a state: only what stands in der() can be reinitialised", ""),
    (r"(cyclic dependency in parameter binding for '.*?').*", r"\1: parameters depend on each other in a ring", ""),
)  # fmt: skip
"""What the front end says in its own terms; what it means; and, if the message has no name, what to look for."""

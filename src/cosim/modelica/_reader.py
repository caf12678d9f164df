"""Reads rumoca's flat tree into a :class:`FlatModel`; refuses, with the place, what it has no reading for."""

from __future__ import annotations

import itertools
from dataclasses import replace

from cosim.modelica._completeness import completed
from cosim.modelica._expressions import ExpressionReader, Tree, place, tag
from cosim.modelica._statements import StatementReader
from cosim.modelica.expressions import (
    Binary,
    Call,
    Expression,
    Field,
    If,
    Literal,
    Output,
    Reference,
    UserCall,
    put_in,
)
from cosim.modelica.flat import (
    Causality,
    Equation,
    FlatModel,
    StateSelect,
    Type,
    Variability,
    Variable,
    When,
    targets,
)
from cosim.modelica.source import Source


def read(tree: Tree, model: str, source: Source) -> FlatModel:
    """Read the tree that ``to_dict("flat")`` of rumoca 0.10 gives.

    Raises:
        ModelError: something in the model is outside what is supported, by name and place.
    """
    flat = _Reader(tree, source).model(model)
    return completed(flat, frozenset(tree["structural_parameters"]), source.find_class(model))


def _enumerations(ordinals: dict[str, int]) -> dict[str, tuple[str, ...]]:
    """The literals of each enumeration by its full name.

    The flat tree lists each literal by its full name, then, with what comes last of the type's name, once more in a
    short form, which is not unique, and both again in quotes.
    """
    found: dict[str, tuple[str, ...]] = {}
    last = ""
    for key in ordinals:
        if "'" in key or key == ".".join(last.split(".")[-2:]):
            continue
        last = key
        name, _, literal = key.rpartition(".")
        found[name] = (*found.get(name, ()), literal)
    return found


class _Reader:
    def __init__(self, tree: Tree, source: Source) -> None:
        self._tree = tree
        self._source = source
        self._expression = ExpressionReader(source, tree["derivative_marker"])
        self._statement = StatementReader(source, self._expression)
        types = _enumerations(tree["enum_literal_ordinals"])
        self._ordinals = {f"{name}.{literal}": k for name, type_ in types.items() for k, literal in enumerate(type_, 1)}
        self._enumerations = dict(zip(sorted(tree["enumeration_type_roots"]), types.values(), strict=True))
        """Literals by rumoca's number of the type; numbers and names are both in the order of declaration."""

    def model(self, name: str) -> FlatModel:
        tree, statement = self._tree, self._statement
        if tree["definite_roots"] or tree["potential_roots"] or tree["branches"]:
            raise self._source.error(
                "Connections.root, branch and potentialRoot are not supported: connectors may not be overconstrained;"
                " give orientations by angles",
                self._source.find("Connections"),
            )
        variables = {key: self._variable(value) for key, value in tree["variables"].items()}
        whens = [statement.when(chain) for chain in tree["when_chains"]]
        whens += [
            When(((Call("initial", (), assertion.at), (assertion,)),), sequential=False, at=assertion.at)
            for assertion in map(statement.assertion, tree["initial_assert_equations"])
        ]
        algorithms = []
        for node in tree["algorithms"]:
            statements, inside = statement.algorithm(node)
            whens += inside
            if statements.statements:
                algorithms.append(statements)
        for target in {target for when in whens for _, actions in when.branches for target in targets(actions)}:
            # a Real that is assigned in a when-clause is discrete, declared so or not (Modelica 4.5.1)
            if target in variables:
                variables[target] = replace(variables[target], variability="discrete")
        return FlatModel(
            name=name,
            source=self._source,
            description=tree["model_description"],
            variables=variables,
            equations=(*self._bindings(variables), *self._equations("")),
            initial_equations=tuple(self._equations("initial_")),
            whens=tuple(whens),
            assertions=tuple(statement.assertion(node) for node in tree["assert_equations"]),
            enumeration_values=self._ordinals,
            algorithms=tuple(algorithms),
            initial_algorithms=tuple(statement.initial_algorithm(node) for node in tree["initial_algorithms"]),
            functions={
                key: statement.function(node)
                for key, node in tree["functions"].items()
                if key != tree["derivative_marker"]
            },
        )

    @staticmethod
    def _bindings(variables: dict[str, Variable]) -> list[Equation]:
        """Declaration equations, which the flat tree keeps with the variables: ``Real x = a`` and ``S s(u = a)``."""
        return [
            Equation(Binary("-", Reference(v.name, (), v.at), v.binding, v.at), "Declaration", v.at)
            for v in variables.values()
            if v.binding is not None and v.variability not in ("parameter", "constant") and v.causality != "input"
        ]

    def _variable(self, node: Tree) -> Variable:
        name: str = node["name"]
        at = int(node["source_span"]["start"])
        type_name: str = self._tree["variable_type_names"].get(name, "Real")
        kind, literals = self._type(node, type_name)
        declared, _ = tag(node["variability"])
        variability: Variability = "continuous"
        if declared in ("Parameter", "Constant"):
            variability = "parameter" if declared == "Parameter" else "constant"
        elif declared == "Discrete" or kind != "Real":
            variability = "discrete"
        causality: Causality = "local"
        direction, _ = tag(node["causality"])
        if "." not in name and direction in ("Input", "Output"):
            causality = "input" if direction == "Input" else "output"
        select: StateSelect = str(node["state_select"]).lower()  # type: ignore[assignment]
        fixed = node["fixed"]
        if isinstance(fixed, list):
            if any(fixed) and not all(fixed):
                raise self._source.error(f"{name}: fixed must be the same for all elements of an array", at)
            fixed = all(fixed)
        if node.get("stream"):
            raise self._source.error(f"{name} is a stream variable; connectors with stream variables are not supported,"
                                     " only potential and flow variables", at)  # fmt: skip
        return Variable(
            name=name,
            type=kind,
            variability=variability,
            causality=causality,
            dimensions=tuple(node["dims"]),
            start=self._start(node),
            fixed=fixed,
            binding=self._expression.optional(node["binding"]),
            minimum=self._expression.optional(node["min"]),
            maximum=self._expression.optional(node["max"]),
            nominal=self._expression.optional(node["nominal"]),
            unit=node["unit"],
            display_unit=node["display_unit"],
            quantity=node["quantity"],
            description=node["description"],
            state_select=select,
            final=bool(self._tree["variable_final_flags"].get(name, False)),
            protected=bool(node["is_protected"]),
            literals=literals,
            at=at,
        )

    def _type(self, node: Tree, type_name: str) -> tuple[Type, tuple[str, ...]]:
        effective = self._tree["effective_types"][str(node["type_id"])]
        builtin = {number: name for name, number in self._tree["predefined_types"].items()}
        base = builtin.get(effective["canonical_type"])
        if base in ("real", "integer", "boolean", "string"):
            return base.capitalize(), ()
        literals = self._enumerations.get(effective["canonical_type"])
        if literals is None:
            hint = "; use when sample(start, interval) and pre()" if type_name == "Clock" else ""
            at = int(node["source_span"]["start"])
            raise self._source.error(f"{node['name']}: variables of type {type_name} are not supported{hint}", at)
        return "Enumeration", literals

    def _start(self, node: Tree) -> Expression | None:
        """The start value that the model gives; where it gives none, rumoca has zero, placed at the declaration."""
        start = node["start"]
        if start is not None and "Literal" in start and start["Literal"].get("span") == node["source_span"]:
            return None
        return self._expression.optional(start)

    def _equations(self, kind: str) -> list[Equation]:
        """The equations, with those that the flat tree gives only as the template of a for-loop put in their places.

        Args:
            kind: empty, or ``initial_``.
        """
        nodes = self._tree[f"{kind}equations"]
        residuals: list[Expression | None] = [None] * len(nodes)
        for family in self._tree[f"{kind}structured_equations"]:
            if family["interiors_materialized"]:
                continue
            body = [self._expression(residual) for residual in family["template"]["body"]]
            binders = family["domain"]["binders"]
            ranges = [range(b["lower"], b["upper"] + (1 if b["step"] > 0 else -1), b["step"]) for b in binders]
            position = int(family["first_equation_index"])
            for point in itertools.product(*ranges):
                indices = {b["display_name"]: Literal(k, place(family)) for b, k in zip(binders, point, strict=True)}
                for residual in body:
                    residuals[position] = put_in(residual, indices)
                    position += 1
        found: list[Equation] = []
        for node, known in zip(nodes, residuals, strict=True):
            found += self._equation(node, known)
        return found

    def _equation(self, node: Tree, residual: Expression | None) -> list[Equation]:
        """One equation; one for each output or component where several are set equal at once."""
        variant, content = tag(node["origin"])
        origin = f"{variant}:{content.get('component', '') if isinstance(content, dict) else ''}"
        at = place(node)
        if residual is None:
            sides = node["residual"].get("Binary")
            if sides is not None and "Tuple" in sides["lhs"]:
                return self._outputs(sides["lhs"]["Tuple"]["elements"], self._expression(sides["rhs"]), origin, at)
            residual = self._expression(node["residual"])
        if isinstance(residual, Binary) and residual.operator == "-":
            for side in (residual.left, residual.right):
                if isinstance(side, Reference) and side.name in self._tree["record_instances"]:
                    return [
                        Equation(Binary("-", component(residual.left, field), component(residual.right, field), at),
                                 origin, at)
                        for field in self._fields(side.name)
                    ]  # fmt: skip
        return [Equation(residual, origin, at)]

    def _outputs(self, left: list[Tree], call: Expression, origin: str, at: int) -> list[Equation]:
        """The equations of ``(a, b) = function(...)``."""
        if not isinstance(call, UserCall):
            raise self._source.error("only a call of a function can be equal to a list of variables", at)
        found: list[Equation] = []
        for position, node in enumerate(left):
            target, value = self._expression(node), Output(call, position, at)
            if isinstance(target, Reference) and target.name in self._tree["record_instances"]:
                for field in self._fields(target.name):
                    found.append(
                        Equation(Binary("-", component(target, field), Field(value, field, at), at), origin, at)
                    )
            else:
                found.append(Equation(Binary("-", target, value, at), origin, at))
        return found

    def _fields(self, record: str) -> list[str]:
        return [name[len(record) + 1 :] for name in self._tree["variables"] if name.startswith(f"{record}.")]


def component(record: Expression, name: str) -> Expression:
    """The component ``name`` of an expression that stands for a record."""
    match record:
        case Reference(subscripts=()):
            return replace(record, name=f"{record.name}.{name}")
        case If(branches=branches, otherwise=otherwise):
            parts = tuple((condition, component(value, name)) for condition, value in branches)
            return replace(record, branches=parts, otherwise=component(otherwise, name))
    return Field(record, name, record.at)

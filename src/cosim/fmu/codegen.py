"""Writes the C of one model: ``model_sizes.h`` and ``model.c``, everything that the runtime's ``model.h`` declares."""

from __future__ import annotations

import itertools
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import casadi as ca

from cosim.dae import Dae
from cosim.dae.dae import Computed
from cosim.dae.hybrid import SX
from cosim.dae.sweep import newton_sweep
from cosim.dae.symbolic import substitute
from cosim.fmu.algebraic_functions import algebraic_functions, initial_functions
from cosim.fmu.c_expressions import SCALARS, number, print_function
from cosim.fmu.c_text import WIDTH, comment, function, remark, scope, string, table
from cosim.fmu.constraint_tables import constraint_sizes, constraint_tables
from cosim.fmu.derivatives import derivatives, of_parameters, seeds
from cosim.fmu.discrete_groups import Group, Keeping, group_assignments, is_all_clocked, what_to_keep
from cosim.fmu.layout import Layout
from cosim.fmu.loops import Run, c_expression, find_runs, shared

_CONTINUOUS = ("t", "v", "u", "p", "d", "c")
_DISCRETE = (*_CONTINUOUS, "pre", "fired", "initial", "d_new", "kept")
_UNUSED = "    (void)t, (void)v, (void)u, (void)p, (void)d, (void)c;"


def generate(dae: Dae, layout: Layout, token: str, fixed_step: float | None = None) -> dict[str, str]:
    """The generated files by name.

    Args:
        dae: the model.
        layout: where its variables live.
        token: the FMU's instantiation token.
        fixed_step: the length of all steps [s], ``None`` for error control.
    """
    generator = _Generator(dae, layout)
    return {"model_sizes.h": generator.sizes(token, fixed_step), "model.c": generator.model()}


class _Generator:
    def __init__(self, dae: Dae, layout: Layout) -> None:
        self._dae = dae
        self._layout = layout
        self._named = [v for v in dae.computed if not v.value.is_leaf()]
        self._swept = newton_sweep(dae.residuals, [unknown.symbol for unknown in dae.torn]) if dae.torn else None
        self._all_clocked = is_all_clocked(dae)
        self._groups = group_assignments(dae)
        nothing = Keeping(frozenset(), (frozenset(),) * len(self._groups), {})
        self._keeping = what_to_keep(dae, self._groups) if self._all_clocked else nothing
        discretes = [s.name for s in dae.discretes]
        self._labels: dict[str, list[str]] = {
            "t": ["time"],
            "v": [u.name for u in dae.unknowns],
            "u": [s.name for s in dae.inputs],
            "p": [p.scalar.name for p in dae.parameters],
            "d": discretes,
            "c": [f"relation_{k}" for k in range(len(dae.relations))],
            "pre": [f"pre_{name}" for name in discretes],
            "fired": [f"fired_{k}" for k in range(len(dae.clocks))],
            "initial": ["initial"],
            "d_new": [f"new_{name}" for name in discretes],
            "kept": [f"pre_{discretes[k]}" for k in self._keeping.place],
        }
        self._seeds = seeds(dae, len(layout.outputs))
        self._labels |= {name: [f"{name}_{k}" for k in range(seed.numel())] for name, seed in self._seeds.items()}
        self._arguments: dict[str, SX] = self._seeds | {
            "t": dae.time,
            "v": dae.v,
            "u": _column([s.symbol for s in dae.inputs]),
            "p": _column([p.scalar.symbol for p in dae.parameters]),
            "d": _column([s.symbol for s in dae.discretes]),
            "c": _column([r.symbol for r in dae.relations]),
            "pre": _column([dae.pre[name] for name in discretes]),
            "fired": _column([c.fired for c in dae.clocks]),
            "initial": dae.initial,
            "d_new": _column([dae.new[name] for name in discretes]),
            "kept": _column([SX.sym(f"kept({discretes[k]})") for k in self._keeping.place]),
        }

    def sizes(self, token: str, fixed_step: float | None) -> str:
        dae, layout = self._dae, self._layout
        values = {
            "NX": len(dae.states), "NZ": len(dae.torn), "NU": len(dae.inputs), "NP": len(dae.parameters),
            "ND": len(dae.discretes), "NG": len(dae.relations), "NS": len(dae.clocks), "NY": len(layout.outputs),
            "NL": len(layout.locals), "NA": len(dae.checks), "NE": len(dae.terminations),
            "NVARIABLES": len(layout.slots),
        }  # fmt: skip
        values |= constraint_sizes(dae.constraints)
        values["ALL_CLOCKED"] = int(self._all_clocked)
        values["HAS_TIME_RELATIONS"] = int(any(r.slope for r in dae.relations))
        values["TERMINAL"] = next((k for k, clock in enumerate(dae.clocks) if clock.terminal), -1)
        values["HAS_DERIVATIVES"] = 1
        values["HAS_SWEEP"] = int(self._swept is not None)
        lines = [f"/* Sizes of {dae.name}. */", "#ifndef COSIM_MODEL_SIZES_H", "#define COSIM_MODEL_SIZES_H", ""]
        lines += [f"#define MODEL_{name} {value}" for name, value in values.items()]
        lines += ["#define MODEL_HAS_FIXED_STEP 1", f"#define MODEL_FIXED_STEP {fixed_step!r}"] if fixed_step else []
        lines += [f"#define MODEL_NAME {string(dae.name)}", f"#define MODEL_TOKEN {string(token)}", "", "#endif", ""]
        return "\n".join(lines)

    def model(self) -> str:
        dae = self._dae
        parts = [f"/* {dae.name}: {comment(dae.description or '')} */", '#include "model.h"', "", "#include <math.h>",
                 "#include <string.h>", "", '#include "elementary.h"', ""]  # fmt: skip
        parts += self._tables()
        parts += self._parameters()
        parts += self._start()
        parts += self._clocks()
        f = dae.f
        parts += self._block_comments()
        parts += self._continuous("model_rhs", {"f": f}, self._equation_comment())
        derivatives = {"f": f, "J": ca.jacobian(f, dae.v), "ft": ca.jacobian(f, dae.time)}
        parts += self._continuous("model_linearise", derivatives, "f, df/dv column by column, explicit df/dt")
        parts += self._residuals()
        relations = "; ".join(f"{k}: {r.text}" for k, r in enumerate(dae.relations))
        indicators = _column([r.indicator for r in dae.relations])
        parts += self._continuous("model_indicators", {"g": indicators}, relations)
        parts += self._continuous("model_outputs", {"y": _column(self._layout.outputs)}, "")
        parts += self._sweep()
        parts += self._continuous("model_locals", {"l": _column(self._layout.locals)}, "")
        parts += self._derivatives()
        parts += self._assertions()
        parts += self._discrete()
        if dae.constraints:
            tables, entries = constraint_tables(dae.constraints)
            for t in tables:
                values = [string(value) for value in t.values] if "char" in t.kind else t.values
                parts += [f"const {t.kind} model_{t.name}[MODEL_{t.size}] = {{{', '.join(values)}}};", ""]
            parts += self._continuous("model_constraint_entries", {"entries": entries}, "")
        return "\n".join(parts)

    def _equation_comment(self) -> str:
        dae = self._dae
        derivatives = [f"f[{k}] = der({s.name})" for k, s in enumerate(dae.states)]
        residuals = [f"f[{len(dae.states) + k}] = residual solved for {z.name}" for k, z in enumerate(dae.torn)]
        return "; ".join(derivatives + residuals)

    def _block_comments(self) -> list[str]:
        lines: list[str] = []
        for place, block in enumerate(self._dae.coupled_blocks, 1):
            lines.append(f"/* Block {place}: {comment(str(block))}:")
            for equation in block.equations:
                text = comment(self._dae.equations[equation])
                lines += textwrap.wrap(text, WIDTH, initial_indent=" *     ", subsequent_indent=" *         ")
            lines.append(" */")
        return [*lines, ""] if lines else []

    # tables

    def _tables(self) -> list[str]:
        dae, slots = self._dae, self._layout.slots
        entries = [f"{{{s.store}, {s.type}, {s.settable}, {s.index}}}, /* {s.name} */" for s in slots]
        starts = {s.name: s.start for s in slots if s.scalar is not None and s.start is not None}
        return [
            "const ModelVariable model_variables[MODEL_ROOM(MODEL_NVARIABLES)] = {",
            *(f"    {entry}" for entry in entries),
            "};",
            "",
            *table("double", "model_start_inputs", "MODEL_NU", [number(starts[s.name] or 0.0) for s in dae.inputs]),
            *table("double", "model_start_parameters", "MODEL_NP",
                    [number(dae.parameter_values[p.scalar.name]) for p in dae.parameters]),
            *table("double", "model_nominal", "MODEL_NV", [number(u.nominal) for u in dae.unknowns]),
            *table("char *const", "model_unknown_names", "MODEL_NV", [string(u.name) for u in dae.unknowns]),
            *table("char *const", "model_discrete_names", "MODEL_ND", [string(s.name) for s in dae.discretes]),
            *table("unsigned char", "model_relation_strict", "MODEL_NG", [str(int(r.strict)) for r in dae.relations]),
            *(table("double", "model_relation_slope", "MODEL_NG", [number(r.slope) for r in dae.relations])
              if any(r.slope for r in dae.relations) else ()),
            *table("char *const", "model_relation_texts", "MODEL_NG", [string(r.text) for r in dae.relations]),
            *table("char *const", "model_assertion_messages", "MODEL_NA", [string(c.message) for c in dae.checks]),
            *table("unsigned char", "model_assertion_is_error", "MODEL_NA",
                    [str(int(c.is_error)) for c in dae.checks]),
            *table("char *const", "model_termination_messages", "MODEL_NE", [string(m) for _, m in dae.terminations]),
            *table("unsigned char", "model_start_kept", "MODEL_NV", [str(int(k)) for k in dae.starts_kept]),
            *table("char *const", "model_initial_texts", "MODEL_NV", [string(t) for t in dae.initial_texts]),
        ]  # fmt: skip

    # functions of the parameters

    def _parameters(self) -> list[str]:
        dependent = [(k, p) for k, p in enumerate(self._dae.parameters) if not p.independent]
        values: dict[str, SX] = {}
        for _, parameter in dependent:
            values[parameter.scalar.name] = substitute(parameter.value, values)
        expressions = [values[p.scalar.name] for _, p in dependent]
        # every value is in terms of independent parameters, so the order does not matter
        body = ["(void)p;", *self._elements(["p"], "p", expressions, [k for k, _ in dependent])]
        return function("MODEL_COLD void model_parameters(double *p)", body)

    def _start(self) -> list[str]:
        dae = self._dae
        v = [u.start for u in dae.unknowns]
        d = [SX(0.0) if s.start is None else s.start for s in dae.discretes]
        body = ["(void)p, (void)v, (void)d;"]
        for name, values in (("v", v), ("d", d)):
            body += scope(self._elements(["p"], name, values, list(range(len(values)))))
        return function("void model_start(const double *p, double *v, double *d)", body)

    def _clocks(self) -> list[str]:
        clocks = self._dae.clocks
        start, interval = _column([c.start for c in clocks]), _column([c.interval for c in clocks])
        body = ["(void)p, (void)start, (void)interval;", *self._body(["p"], [("start", start), ("interval", interval)])]
        return function("void model_clocks(const double *p, double *start, double *interval)", body)

    # functions of the continuous arguments

    def _continuous(self, name: str, results: Mapping[str, SX], about: str, seeds: Sequence[str] = ()) -> list[str]:
        """A function of the continuous arguments and of seeds; its results go to the arrays of these names.

        One with seeds, and that of the locals, is needed seldom: it is to be small rather than fast.
        """
        given = [f"double {seed}" if seed in SCALARS else f"const double *{seed}" for seed in seeds]
        arrays = ", ".join([*given, *(f"double *{result}" for result in results)])
        unused = "".join(f", (void){argument}" for argument in [*seeds, *results])
        cold = "MODEL_COLD " if seeds or name == "model_locals" else ""
        head = f"{cold}void {name}(MODEL_CONTINUOUS_ARGUMENTS, {arrays})"
        head = "\n".join(textwrap.wrap(head, WIDTH, subsequent_indent=" " * (len(cold + name) + 6)))
        body = [f"{_UNUSED.strip()[:-1]}{unused};", *self._body([*_CONTINUOUS, *seeds], list(results.items()))]
        lines = function(head, body)
        return [*remark(comment(about)), *lines] if about else lines

    def _residuals(self) -> list[str]:
        dae = self._dae
        # where there is a sweep, Newton's method is the last resort
        taken = algebraic_functions(dae) if self._swept is not None else None
        if taken is not None:
            return taken
        algebraic = {"r": dae.residuals, "J": ca.jacobian(dae.residuals, dae.z)}
        return [
            *self._continuous("model_residual", {"r": dae.residuals}, "the residuals alone"),
            *self._continuous("model_linearise_residual", algebraic, "the residuals and their derivatives by z"),
        ]

    def _sweep(self) -> list[str]:
        """The outputs together with what makes them exact: most of their operations are the same."""
        if self._swept is None:
            return []
        z = self._dae.z
        outputs = ca.substitute(_column(self._layout.outputs), z, self._swept)
        return self._continuous("model_sweep", {"dz": self._swept - z, "y": outputs}, "corrections of z, then outputs")

    def _derivatives(self) -> list[str]:
        outputs = _column(self._layout.outputs)
        found = derivatives(self._dae, outputs, self._arguments, self._seeds)
        lines = [line for d in found for line in self._continuous(d.name, d.results, d.about, d.seeds)]
        lines += initial_functions(self._dae, self._arguments, self._seeds["r_bar"], self._body)
        free = of_parameters(self._dae, self._seeds["p_bar"])
        body = ["(void)p, (void)p_bar, (void)free_bar;", *self._body(["p", "p_bar"], [("free_bar", free)])]
        head = "MODEL_COLD void model_parameters_reverse(const double *p, const double *p_bar, double *free_bar)"
        return [*lines, *remark("weights of the independent parameters from those of all"), *function(head, body)]

    def _assertions(self) -> list[str]:
        checks = self._dae.checks
        body = [_UNUSED.strip()]
        if checks:
            body += [f"double holds[{len(checks)}];"]
            body += self._body(_CONTINUOUS, [("holds", _column([c.condition for c in checks]))])
            body += [f"for (int k = 0; k < {len(checks)}; k++) {{", "    if (holds[k] == 0) return k;", "}"]
        return function("int model_violated_assertion(MODEL_CONTINUOUS_ARGUMENTS)", [*body, "return -1;"])

    # events

    def _discrete(self) -> list[str]:
        dae = self._dae
        body = [_UNUSED.strip(), "(void)pre, (void)fired, (void)initial, (void)d_new, (void)x_new;"]
        at_head = self._keeping.at_head
        if self._keeping.place:
            body += [f"double kept[{len(self._keeping.place)}];", *self._copies(at_head)]
        for group, own in zip(self._groups, self._keeping.in_group, strict=True):
            body += self._group(group, own)
        for reset in dae.resets:
            value = [f"x_new[{reset.index}] = value[0];"]
            compute = self._body(_DISCRETE, [("value", reset.value)])
            body += self._guarded(reset.guard, ["double value[1];", *compute, *value])
        body.append("int terminate = 0;")
        for k, (guard, _) in enumerate(dae.terminations):
            body += self._guarded(self._from_kept(guard, at_head), [f"terminate = {k + 1};"])
        body.append("return terminate;")
        head = (
            "int model_discrete(MODEL_CONTINUOUS_ARGUMENTS, const double *pre, const double *fired, int initial,\n"
            "                   double *d_new, double *x_new)"
        )
        return function(head, body)

    def _from_kept(self, value: SX, entries: Iterable[int]) -> SX:
        """``value`` with these entries of ``pre`` read from where they are kept."""
        pre, kept = self._arguments["pre"], self._arguments["kept"]
        return substitute(value, {pre[k].name(): kept[self._keeping.place[k]] for k in entries})

    def _copies(self, entries: Iterable[int]) -> list[str]:
        """Keep these entries of ``pre``."""
        lines = []
        for first, count in _ranges(sorted(entries)):
            place = self._keeping.place[first]
            one = f"kept[{place}] = pre[{first}];"
            lines.append(one if count == 1 else f"memcpy(&kept[{place}], &pre[{first}], {count} * sizeof *kept);")
        return lines

    def _group(self, group: Group, own: frozenset[int]) -> list[str]:
        """Assignments with one guard, computed together; ``own`` are the entries of ``pre`` kept for them alone."""
        late = self._keeping.at_head | own
        values = ca.vertsplit(self._from_kept(_column(group.values), late))
        body = [*self._copies(own), *self._elements(_DISCRETE, "d_new", values, group.positions)]
        body += [
            f"if (model_has_nan(d_new + {first}, {count})) return MODEL_NOT_A_NUMBER;"
            for first, count in _ranges(group.positions)
        ]
        heading = remark(comment(group.text))
        if group.guard is None:
            return [*heading, *scope(body)]
        return [*heading, *self._guarded(self._from_kept(group.guard, self._keeping.at_head), body)]

    def _guarded(self, guard: SX, body: list[str]) -> list[str]:
        condition = self._body(_DISCRETE, [("active", guard)])
        return ["{", "    double active[1];", *(f"    {line}" for line in condition), "    if (active[0] != 0) {",
                *(f"        {line}" for line in body), "    }", "}"]  # fmt: skip

    def _elements(
        self, arguments: Sequence[str], array: str, values: Sequence[SX], positions: Sequence[int]
    ) -> list[str]:
        """Assign ``array[positions[i]] = values[i]``, with loops where many elements are computed alike."""
        if not values:
            return []
        elements = ca.vertsplit(ca.cse(_column(values)))
        runs = self._runs(arguments, elements, positions)
        looped = {i for run in runs for i in range(run.start, run.start + run.count)}
        plain = [i for i in range(len(elements)) if i not in looped]
        before: dict[int, SX] = {e.element_hash(): e for run in runs for e in shared(run.pattern)}
        results = [(array, _column([elements[i] for i in plain])), ("shared", _column(list(before.values())))]
        lines = [f"double shared[{len(before)}];"] if before else []
        named = [Computed(self._labels[array][positions[i]], elements[i], "") for i in plain]
        body = self._body(arguments, results, named)
        lines += [_moved(line, array, [positions[i] for i in plain]) for line in body]
        names = {key: f"shared[{i}]" for i, key in enumerate(before)}
        for run in runs:
            first = positions[run.start]
            target = f"{array}[{first} + k]" if first else f"{array}[k]"
            lines.append(f"for (int k = 0; k < {run.count}; k++) {target} = {c_expression(run.pattern, names)};")
        return lines

    def _runs(self, arguments: Sequence[str], elements: Sequence[SX], positions: Sequence[int]) -> list[Run]:
        """The runs among elements whose positions are consecutive too."""
        places = {
            symbol.name(): (name, i)
            for name in arguments
            if name not in SCALARS
            for i, symbol in enumerate(ca.vertsplit(self._arguments[name]))
        }
        found: list[Run] = []
        start = 0
        for end in range(1, len(elements) + 1):
            if end == len(elements) or positions[end] != positions[end - 1] + 1:
                runs = find_runs(elements[start:end], places)
                found += [replace(run, start=run.start + start) for run in runs]
                start = end
        return found

    def _body(
        self, arguments: Sequence[str], results: Sequence[tuple[str, SX]], named: Sequence[Computed] = ()
    ) -> list[str]:
        """The lines that compute ``results``, with names for those of ``named`` that come on the way."""
        outputs = [ca.densify(ca.vec(expression)) for _, expression in results]
        if sum(o.numel() for o in outputs) == 0:
            return []
        named = [*named, *(self._named if "v" in arguments else ())]
        outputs.append(_column([variable.value for variable in named]))
        shared = ca.vertsplit(ca.cse(ca.vertcat(*outputs)), [0, *_cumulative(o.numel() for o in outputs)])
        function = ca.Function("f", [self._arguments[name] for name in arguments], list(shared))
        labels = [self._labels[name] for name in arguments]
        titles = [(variable.name, comment(variable.remark)) for variable in named]
        return print_function(function, arguments, [name for name, _ in results], labels, titles)


def _moved(line: str, array: str, positions: Sequence[int]) -> str:
    """Results are numbered in order; put each where its variable lives."""
    if not line.startswith(f"{array}["):
        return line
    number_text, rest = line[len(array) + 1 :].split("]", 1)
    return f"{array}[{positions[int(number_text)]}]{rest}"


def _ranges(positions: Sequence[int]) -> list[tuple[int, int]]:
    """Where runs of consecutive numbers begin, and how long they are."""
    ranges: list[tuple[int, int]] = []
    for position in sorted(positions):
        if ranges and position == sum(ranges[-1]):
            ranges[-1] = (ranges[-1][0], ranges[-1][1] + 1)
        else:
            ranges.append((position, 1))
    return ranges


def _cumulative(sizes: Iterable[int]) -> list[int]:
    return list(itertools.accumulate(sizes))


def _column(values: Sequence[SX]) -> SX:
    return ca.vertcat(SX(0, 1), *values)

"""How the front end's flat tree is read: loops, enumerations, start values, places."""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim.fmu import compile_model
from cosim.modelica import FlatModel, Source, flatten
from cosim.modelica.expressions import render_equation

pytest.importorskip("rumoca")

SMALL = Path(__file__).parents[1] / "models" / "Small"


def flat(tmp_path: Path, text: str, model: str = "M") -> FlatModel:
    file = tmp_path / "M.mo"
    file.write_text(text, encoding="utf-8")
    return flatten(Source.read(file), model)


def texts(model: FlatModel) -> list[str]:
    return [render_equation(equation.residual) for equation in model.equations]


def test_a_loop_that_the_front_end_keeps_as_a_template_is_expanded() -> None:
    rod = flatten(Source.read(SMALL / "Rod.mo"), "Small.Rod")
    assert [text for text in texts(rod) if text.startswith("der")] == [
        f"der(T[{k}]) = q[{k}] - q[{k} + 1]" for k in range(1, 9)
    ]


def test_nested_and_descending_loops_keep_their_order(tmp_path: Path) -> None:
    model = flat(
        tmp_path,
        """model M
             parameter Integer n = 2;
             Real a[2,3]; Real b[3]; Real x(start=0, fixed=true);
           equation
             der(x) = 1;
             for i in 1:2 loop for j in 1:3 loop a[i,j] = x*i + j; end for; end for;
             for k in 3:-1:1 loop b[k] = a[1,k] + k; end for;
           end M;""",
    )
    assert texts(model)[1:] == [
        *(f"a[{i},{j}] = x * {i} + {j}" for i in (1, 2) for j in (1, 2, 3)),
        *(f"b[{k}] = a[1,{k}] + {k}" for k in (3, 2, 1)),
    ]


def test_enumerations_of_one_name_are_told_apart(tmp_path: Path) -> None:
    model = flat(
        tmp_path,
        """type Top = enumeration(q, r);
           package P
             package Z
               package Q type Colour = enumeration(red, green); end Q;
               model M Q.Colour c(start=Q.Colour.green, fixed=true); equation
                 when time > 1 then c = Q.Colour.red; end when; end M;
             end Z;
             type Colour = enumeration(green, white, red);
             package B
               type Colour = enumeration(a1, a2, a3, a4);
               model M Colour c(start=Colour.a1, fixed=true); Top t = Top.q; equation
                 when time > 1 then c = Colour.a2; end when; end M;
             end B;
             model T
               Z.M a; B.M b; Colour d = Colour.red; Real x(start=0, fixed=true);
             equation der(x) = 1; end T;
           end P;""",
        "P.T",
    )
    literals = {name: v.literals for name, v in model.variables.items() if v.literals}
    assert literals == {
        "a.c": ("red", "green"),
        "b.c": ("a1", "a2", "a3", "a4"),
        "b.t": ("q", "r"),
        "d": ("green", "white", "red"),
    }
    assert (model.enumeration_values["P.Colour.red"], model.enumeration_values["P.Z.Q.Colour.red"]) == (3, 1)


def test_only_a_start_value_that_the_model_gives_counts(tmp_path: Path) -> None:
    model = flat(tmp_path, "model M Real x(start=0, fixed=true); Real y; equation der(x) = 1; y = x; end M;")
    assert model.variables["x"].start is not None
    assert model.variables["y"].start is None


def test_declaration_equations_and_modifiers_become_equations(tmp_path: Path) -> None:
    model = flat(tmp_path, "model M model S input Real u; Real y = 2*u; end S; S s(u = time); end M;")
    assert texts(model) == ["s.u = time", "s.y = 2 * s.u"]


def test_a_when_clause_does_not_act_at_the_start() -> None:
    dae = compile_model(SMALL / "Tank.mo", "Small.Tank")
    (starts,) = (a for a in dae.assignments if a.targets == ("starts",))
    assert "initial" in str(starts.guard)


def test_other_files_in_the_folder_do_not_matter(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "M.mo").write_text("model M Real y; equation y = time; end M;")
    (tmp_path / "Other.mo").write_text("model M Real z; end M;")
    (tmp_path / "Broken.mo").write_text("model Broken Real z end")
    monkeypatch.chdir(tmp_path)
    assert texts(flatten(Source.read(Path("M.mo")), "M")) == ["y = time"]

"""What every class of the library promises, whatever it models."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from .conftest import LIBRARY

_KINDS = "model|block|function|connector|type|package"
_HEADING = re.compile(rf"^within (WiperDrive[\w.]*);\n(?:partial )?(?:{_KINDS}) (\w+)", re.M)
_COMPLETE = re.compile(r"^(?:model|block) (\w+)", re.M)
_STANDALONE = ("Systems", "Tests", "Controllers", "Electronics")


def _standalone() -> list[str]:
    """Models that are complete by themselves."""
    files = (file for folder in _STANDALONE for file in sorted((LIBRARY / folder).glob("*.mo")))
    return [f"{file.parent.name}.{file.stem}" for file in files if _COMPLETE.search(file.read_text())]


def _files() -> list[Path]:
    return [file for file in sorted(LIBRARY.rglob("*.mo")) if file != LIBRARY / "package.mo"]


@pytest.mark.parametrize("name", _standalone())
def test_model_flattens_with_as_many_equations_as_unknowns(name: str, load: Callable[[str], Any]) -> None:
    structure = load(name).structure()
    assert structure.n_equations == structure.n_unknowns
    assert structure.is_balanced


@pytest.mark.parametrize("name", _standalone())
def test_every_real_has_a_unit_and_every_variable_a_description(name: str, load: Callable[[str], Any]) -> None:
    variables = load(name).to_dict("flat")["variables"].values()
    assert [v["name"] for v in variables if not v["description"]] == []
    assert [v["name"] for v in variables if not v["unit"] and not v["is_discrete_type"]] == []


@pytest.mark.parametrize("name", _standalone())
def test_every_parameter_says_where_its_value_is_from(name: str, load: Callable[[str], Any]) -> None:
    variables = load(name).to_dict("flat")["variables"].values()
    parameters = [v for v in variables if isinstance(v["variability"], dict) and "Parameter" in v["variability"]]
    provenance = re.compile(r"\S \[[SA]\] \S")
    assert [v["name"] for v in parameters if not provenance.search(v["description"])] == []


@pytest.mark.parametrize("file", _files(), ids=lambda file: str(file.relative_to(LIBRARY)))
def test_file_holds_the_class_that_its_path_names(file: Path) -> None:
    heading = _HEADING.match(file.read_text())
    assert heading is not None
    name = file.parent if file.name == "package.mo" else file.with_suffix("")
    inside = name.relative_to(LIBRARY.parent).parts
    assert heading.groups() == (".".join(inside[:-1]), inside[-1])
    assert file.read_text().endswith((f"\nend {inside[-1]};\n", '";\n'))  # a type ends with its description


@pytest.mark.parametrize("order", sorted(LIBRARY.rglob("package.order")), ids=lambda file: file.parent.name)
def test_package_order_lists_every_member_once(order: Path) -> None:
    listed = order.read_text().split()
    folder = order.parent
    members = {f.stem for f in folder.glob("*.mo")} - {"package"} | {f.name for f in folder.iterdir() if f.is_dir()}
    constants = set(re.findall(r"^  constant \S+ (\w+)", (folder / "package.mo").read_text(), re.M))
    assert sorted(listed) == sorted(members | constants)


def test_no_class_uses_another_library() -> None:
    assert [file.name for file in _files() if re.search(r"\bModelica\.", file.read_text())] == []

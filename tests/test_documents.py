"""README, CONTRIBUTING and docs say what is there: every page, command and package, and links that lead somewhere."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest
import typer

from cosim.cli._app import app

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src" / "cosim"
README = (ROOT / "README.md").read_text(encoding="utf-8")
CONTRIBUTING = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
PAGES = [*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), *(ROOT / "scenarios").glob("*.md")]
LINK = re.compile(r"\]\((?!https?:|#)([^)#\s]+)")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_lead_somewhere(page: Path) -> None:
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    assert [link for link in LINK.findall(text) if not (page.parent / link).exists()] == []


def test_the_readme_leads_to_every_page() -> None:
    linked = {link for link in LINK.findall(README) if link.startswith("docs/") and link.endswith(".md")}
    assert linked == {f"docs/{page.name}" for page in (ROOT / "docs").glob("*.md")}


def test_the_readme_names_every_command_and_no_other() -> None:
    named = set(re.findall(r"`cosim ([a-z][a-z-]*)", README))
    assert named == set(typer.main.get_command(app).commands)  # type: ignore[attr-defined]


def _imported(package: Path) -> set[str]:
    """The packages of cosim that a package imports, also within functions."""
    found: set[str] = set()
    for file in package.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            found |= {name.split(".")[1] for name in names if name.startswith("cosim.")}
    return {name for name in found if (SOURCE / name).is_dir()} - {package.name}


def test_contributing_tells_what_each_package_imports() -> None:
    told = {
        name: {part.strip() for part in imports.split(",") if part.strip()}
        for name, imports in re.findall(r"^\| `src/cosim/(\w+)` \|.*\|([^|]*)\|$", CONTRIBUTING, re.MULTILINE)
    }
    packages = {file.parent.name for file in SOURCE.glob("*/__init__.py")}
    assert told.pop("cli") == {"all"}
    assert told == {name: _imported(SOURCE / name) for name in packages - {"cli"}}


def test_every_command_is_quiet_or_gives_json_if_asked() -> None:
    commands = dict(typer.main.get_command(app).commands)  # type: ignore[attr-defined]
    commands |= commands.pop("measurements").commands
    for name, command in commands.items():
        assert {"--json", "--quiet"} <= {option for parameter in command.params for option in parameter.opts}, name

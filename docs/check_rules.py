"""Writes the table of docs/check.md from the rules themselves: python docs/check_rules.py."""

from __future__ import annotations

from pathlib import Path

from cosim.check import rules

PAGE = Path(__file__).parent / "check.md"
BEGIN = "<!-- rules -->\n"


def table() -> str:
    """Return all rules, one line each."""
    rows = [f"| `{name}` | {severity.name.lower()} | {text} |\n" for name, severity, text in rules()]
    return "| rule | severity | what has to be so |\n|---|---|---|\n" + "".join(rows)


def page() -> str:
    """Return the page with its table renewed."""
    return PAGE.read_text(encoding="utf-8").partition(BEGIN)[0] + BEGIN + table()


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")

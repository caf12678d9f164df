"""Writes docs/thesis.md, docs/claims.md and their pictures: what ``cosim thesis`` makes, with small pictures.

Run with ``python docs/thesis.py`` from a checkout.
"""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

from PIL import Image

from cosim.fmu import catalogue
from cosim.thesis import reproduce

ROOT = Path(__file__).parents[1]
PICTURES = ROOT / "docs" / "pictures" / "thesis"
WIDTH, COLOURS = 720, 32
"""Of a small picture: pixels, and entries of its palette."""


def main() -> None:
    """Make everything in a temporary folder, and take over the pages and the pictures that they show."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        made = reproduce(Path(folder), ROOT / "scenarios", catalogue.ensure)
        for path in made.files:
            if path.suffix == ".md":
                (ROOT / "docs" / path.name).write_text(linked(path.read_text(encoding="utf-8")), encoding="utf-8")
            elif path.suffix == ".png":
                shrink(path, PICTURES / path.name)


def linked(page: str) -> str:
    """Return a page of the command with its pictures, and the study of open choices, where the documentation is."""
    page = page.replace("sensitivity.md", "[sensitivity](sensitivity.md)")
    return re.sub(r"\]\((\w+\.png)\)", r"](pictures/thesis/\1)", page)


def shrink(source: Path, target: Path) -> None:
    """Write a picture with fewer pixels and colours."""
    with Image.open(source) as picture:
        height = round(picture.height * WIDTH / picture.width)
        small = picture.convert("RGB").resize((WIDTH, height), Image.Resampling.LANCZOS)
        few = small.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, kmeans=2, dither=Image.Dither.NONE)
        few.save(target, optimize=True)


if __name__ == "__main__":
    main()

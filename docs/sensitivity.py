"""Make docs/sensitivity.md and its picture: ``python docs/sensitivity.py``."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from cosim.fmu import catalogue
from cosim.thesis import sensitivity

DOCS = Path(__file__).parent

if __name__ == "__main__":
    with TemporaryDirectory() as folder:
        made = sensitivity(
            Path(folder), DOCS.parent / "scenarios", catalogue.ensure, picture="pictures/sensitivity.png"
        )
        for file in made.files[1:]:  # the runs are many; cosim thesis --sensitivity writes them
            (DOCS / file.relative_to(folder)).write_bytes(file.read_bytes())
    print(made.conclusion, made.deciding, sep="\n")

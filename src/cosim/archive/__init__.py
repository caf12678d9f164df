"""Opens FMUs and other zip archives from anywhere: what is dangerous is refused before anything is unpacked."""

from cosim.archive._archive import Archive
from cosim.archive._dangers import MOST_BYTES, MOST_MEMBERS, MOST_RATIO, Danger, dangers
from cosim.archive._xml import utf8_of

__all__ = ["MOST_BYTES", "MOST_MEMBERS", "MOST_RATIO", "Archive", "Danger", "dangers", "utf8_of"]

"""Arrays of SSP 2.0 as their elements, which have the names that the engine gives them: ``u[1]``, ``A[2,1]``."""

from __future__ import annotations

import itertools
import math

from cosim.ssp._xml import Node

_MOST = 100_000


def elements(node: Node, name: str) -> list[str] | None:
    """Return the names of the elements of a connector or parameter in row-major order; None for a scalar.

    Raises `InputError` if a dimension has no fixed size.
    """
    sizes: list[int] = []
    for dimension in (
        *node.children("ssd:Dimension"),
        *node.children("ssc:Dimension"),
        *node.children("ssv:Dimension"),
    ):
        if not dimension.has("size"):
            raise dimension.place.fail(f"'{name}' is an array without a fixed size; give its Dimension a size")
        sizes.append(int(dimension.text("size")))
    if math.prod(sizes) > _MOST:
        raise node.place.fail(f"'{name}' is an array of {math.prod(sizes)} elements; {_MOST} are accepted")
    if not sizes:
        return None
    return [f"{name}[{','.join(map(str, index))}]" for index in itertools.product(*(range(1, n + 1) for n in sizes))]

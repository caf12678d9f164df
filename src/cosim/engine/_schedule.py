"""The order in which connected outputs are computed, each after all that it depends on, and loops as a whole."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from cosim.engine._graph import Depends, End, Loop, arrows_between, loops_among
from cosim.engine._system import Connection


@dataclass(frozen=True)
class Reading:
    """Outputs of one component that are computed together: its inputs are set, as far as known, and these are read."""

    outputs: tuple[End, ...]

    @property
    def component(self) -> str:
        """Return the name of the component."""
        return self.outputs[0][0]


Step: TypeAlias = Reading | Loop


def schedule(
    connections: Sequence[Connection], depends: Depends, names: Sequence[str], held: Collection[End] = ()
) -> list[Step]:
    """Return steps that compute the sources of all connections.

    ``names`` are the components, in the order in which they are looked at; a component is read as soon as that gives
    something new. The sources in ``held`` are known before the first step, and are computed all the same.
    """
    arrows = arrows_between(connections, depends)
    free = [connection for connection in connections if connection.source not in held]
    waits: dict[End, set[End]] = {output: set() for output in arrows}
    for source, targets in arrows.items():
        for target in targets if source not in held else ():
            waits[target].add(source)
    outputs = {name: [output for output in arrows if output[0] == name] for name in names}
    loops = loops_among(free, depends)
    steps: list[Step] = []
    done: set[End] = set()
    while len(done) < len(arrows):
        before = len(done)
        for name in names:
            ready = [output for output in outputs[name] if output not in done and waits[output] <= done]
            if ready:
                steps.append(Reading(tuple(ready)))
                done.update(ready)
        if len(done) == before:  # what is left waits for loops, and the first of these for nothing else
            loop = loops.pop(0)
            steps.append(loop)
            done.update(loop.torn, loop.others)
    return steps

"""The order in which connected outputs are computed, each after all that it depends on, and loops as a whole."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from cosim.engine.system._connection import Connection
from cosim.engine.system._graph import Depends, End, Loop, arrows_between, loops_among


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
    place = {name: i for i, name in enumerate(names)}
    steps: list[Step] = []
    done: set[End] = set()
    look = set(names)  # at components for which something has become known
    while len(done) < len(arrows):
        before = len(steps)
        for name in sorted(look, key=place.__getitem__):
            look.discard(name)
            ready = [output for output in outputs[name] if waits[output] <= done]
            if ready:
                steps.append(Reading(tuple(ready)))
                done.update(ready)
                outputs[name] = [output for output in outputs[name] if output not in done]
                look.update(target for output in ready for target, _ in arrows[output])
        if len(steps) == before:  # what is left waits for loops, and the first of these for nothing else
            loop = loops.pop(0)
            steps.append(loop)
            solved = (*loop.torn, *loop.others)
            done.update(solved)
            for output in solved:
                outputs[output[0]].remove(output)
                look.update(target for target, _ in arrows[output])
    return steps

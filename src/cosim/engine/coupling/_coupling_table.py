"""The tables of the native loop for components that act on each other continuously, over the arrays of a coupling."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Mapping, Sequence
from ctypes import Array, addressof, c_double, c_int32, c_int64, c_void_p
from typing import Any

from cosim.engine.coupling._coupling import Correction, Coupling, Member
from cosim.engine.fmu._calls import NUMBERS
from cosim.engine.native import _structures as structures
from cosim.engine.signals._signal_faults import FaultyInput
from cosim.engine.system._wire import Wire

_METHODS = {"extrapolated": 0, "iterated": 1, "adaptive": 2}
_COUNTED = ("known", "macro_steps", "rejected", "repeated", "forced", "wanted", "usual", "error")


class CouplingTable:
    """The table of a coupling, at ``address``, and all memory that it refers to.

    ``places`` are the addresses of the components by their numbers, ``wire`` makes the table of a wire, and ``faulty``
    gives the address of that of an input with faults.
    """

    def __init__(
        self,
        coupling: Coupling,
        places: Mapping[int, int],
        wire: Callable[[Wire], structures.Wire],
        faulty: Callable[[FaultyInput], int],
        parts: int,
    ) -> None:
        """Fill in the table."""
        self._coupling = coupling
        self._memory: list[object] = []
        self._places = places
        keep = self._keep
        links = [
            structures.Link(
                wire(link.wire),
                link.slot,
                faulty(link.faulty) if link.faulty else None,
                link.ahead,
                link.holds_end,
                link.observed,
            )
            for link in coupling.links
        ]
        members = [self._member(member) for member in coupling.members]
        n, n_cut = len(links), len(coupling.cut)
        power = coupling.power
        n_kept = coupling.n_numbers + len(coupling.inputs) + 2 * n + 2 + len(power.energies) + len(power.start)
        others = [places[participant.instance.site.number] for participant in coupling.others]
        self.table = structures.Coupling(
            links=keep((structures.Link * n)(*links)),
            members=keep((structures.Member * len(members))(*members)),
            others=keep((c_void_p * len(others))(*others)),
            cut=self._integers(coupling.cut),
            steady=self._integers(coupling.steady),
            **{
                name: _address(getattr(coupling, name))
                for name in ("start", "end", "last", "before", "full", "times", "was", "matrix", "inputs")
            },
            magnitudes=_address(coupling.scale),
            energies=_address(power.energies),
            powers=_address(power.start),
            **{name: keep((c_double * n_cut)()) for name in ("residual", "change", "probed")},
            scratch=keep((c_double * (n_cut * n_cut + n))()),
            kept=(c_void_p * 2)(*(keep((c_double * n_kept)()) for _ in range(2))),
            n_links=n,
            n_members=len(members),
            n_others=len(others),
            n_cut=n_cut,
            n_steady=len(coupling.steady),
            n_numbers=coupling.n_numbers,
            n_inputs=len(coupling.inputs),
            tolerance=coupling.tolerance,
            stop=coupling.stop,
            divisor=coupling.divisor,
            allowed=float(parts**coupling.method.accuracy),
            method=_METHODS[coupling.method.algorithm],
            order=coupling.method.order,
            loops=bool(coupling.method.loops),
            has_matrix=coupling.has_matrix,
            **{name: getattr(coupling, name) for name in _COUNTED},
        )
        self.address = addressof(self.table)

    def take_back(self) -> None:
        """Put what the native loop has counted into the coupling; its arrays are the loop's own."""
        for name in _COUNTED:
            setattr(self._coupling, name, getattr(self.table, name))
        self._coupling.has_matrix = bool(self.table.has_matrix)

    def _member(self, member: Member) -> structures.Member:
        instance, observed = member.participant.instance, member.observed
        goes_back = self._coupling.method.goes_back
        save, restore = (instance.state_symbol(verb) for verb in ("Get", "Set"))
        table = structures.Member(
            component=self._places[instance.site.number],
            links=self._integers(member.links),
            correction=self._correction(member, member.correction) if member.correction is not None else 0,
            save=instance.pointer(save) if goes_back else 0,
            restore=instance.pointer(restore) if goes_back else 0,
            states=addressof(member.states),
            n_links=len(member.links),
            numbers=(c_int32 * 4)(NUMBERS[save], NUMBERS[restore], NUMBERS["GetDirectionalDerivative"]),
        )
        if observed is not None:
            access = observed.access
            reads = structures.Group(
                access=instance.pointer(access.function),
                references=addressof(access.references),
                memory=access.address,
                doubles=access.address,
                extents=(structures.Extent * 2)(*[structures.Extent(len(access.references), access.length)] * 2),
                component=instance.site.number,
                function=NUMBERS[access.function],
                number=-1,
            )
            table.reads = self._keep((structures.Group * 1)(reads))
            table.observed, table.full, table.scale = map(_address, (observed.values, observed.full, observed.scale))
            table.n_observed = len(observed.values)
        return table

    def _correction(self, member: Member, correction: Correction) -> int:
        table = structures.Correction(
            derivative=member.participant.instance.pointer("GetDirectionalDerivative"),
            inputs=addressof(correction.inputs),
            outputs=addressof(correction.outputs),
            links=self._integers(correction.links),
            slots=self._integers(correction.slots),
            seed=addressof(correction.seed),
            slope=addressof(correction.slope),
            raw=addressof(correction.raw),
            n_links=len(correction.links),
            n_slots=(c_int64 * 2)(correction.n_connected, len(correction.slots)),
        )
        return self._keep((structures.Correction * 1)(table))

    def _integers(self, numbers: Sequence[int]) -> int:
        return self._keep((c_int64 * len(numbers))(*numbers))

    def _keep(self, memory: Array[Any]) -> int:
        self._memory.append(memory)
        return addressof(memory)


def _address(numbers: array[float]) -> int:
    return numbers.buffer_info()[0]

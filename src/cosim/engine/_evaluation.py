"""The functions of a Model Exchange FMU that CVode calls: those of native/exchange.c, over the structure here."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from ctypes import Structure, addressof, c_int32, c_int64, c_void_p, cast

from cosim.engine._calls import NUMBERS, Site
from cosim.engine._cvode import Cvode
from cosim.errors import BuildError


class _Exchange(Structure):
    """As in native/exchange.c."""

    _fields_ = [
        ("instance", c_void_p),
        ("functions", 4 * c_void_p),
        ("data", c_void_p),
        ("at", c_void_p),
        *((name, c_int64) for name in ("n_states", "n_indicators", "evaluations")),
        ("number", c_int32),
        ("numbers", 4 * c_int32),
        *((name, c_int32) for name in ("failed", "status")),
    ]


class Evaluation:
    """One FMU's functions, by their addresses for CVode: ``rates`` and ``indicators``, and ``data`` to call them with.

    ``names`` are the FMI functions that set time and states and give the rates and the indicators, in this order, and
    ``pointers`` their addresses.
    """

    def __init__(
        self,
        library: ctypes.CDLL,
        instance: int,
        names: Sequence[str],
        pointers: Sequence[int],
        sizes: tuple[int, int],
        site: Site,
    ) -> None:
        """Fill in the structure; raises BuildError if the library has another one."""
        library.cosim_exchange_size.restype = c_int64
        if library.cosim_exchange_size() != ctypes.sizeof(_Exchange):
            raise BuildError("the native library has another structure for Model Exchange than is expected; delete it")
        self.rates, self.indicators = (
            cast(function, c_void_p).value or 0 for function in (library.cosim_rates, library.cosim_indicators)
        )
        self._names = names
        self._site = site  # whose memory the structure refers to
        self._exchange = _Exchange(
            instance=instance,
            functions=(c_void_p * 4)(*pointers),
            data=Cvode.array_pointer(),
            at=addressof(site.position),
            n_states=sizes[0],
            n_indicators=sizes[1],
            number=site.number,
            numbers=(c_int32 * 4)(*(NUMBERS[name] for name in names)),
        )
        self.data = addressof(self._exchange)

    @property
    def evaluations(self) -> int:
        """How often the rates were asked for."""
        return int(self._exchange.evaluations)

    @property
    def failure(self) -> tuple[str, int] | None:
        """Function and status of what stopped the solver."""
        exchange = self._exchange
        return (self._names[exchange.failed], int(exchange.status)) if exchange.status else None

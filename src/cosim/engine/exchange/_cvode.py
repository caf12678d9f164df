"""CVode of SUNDIALS, which fmpy brings along: one internal step at a time, roots, and the solution within a step.

A. C. Hindmarsh et al., SUNDIALS, ACM Transactions on Mathematical Software 31 (2005). Variable-order BDF with the dense
linear solver.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from ctypes import byref, c_char_p, c_double, c_int, c_void_p, cast, memmove
from types import SimpleNamespace
from typing import NamedTuple

from cosim.engine.system._arguments import LEAST_TOLERANCE
from cosim.errors import FmuError

Function = Callable[[float, int, int], int]
"""Takes the time [s], the address of the states and that of what is to be filled; returns 0, 1 (recoverable) or -1."""

_SHARE = 0.1
"""Of the tolerance asked for, what a single step may err: CVode controls no more than that, and steps add up."""

_ONE_STEP = 2
_ROOT = 2
_BDF = 2


class Step(NamedTuple):
    """The end of an internal step [s], and whether a root has ended it."""

    time: float
    root: bool


class CvodeError(Exception):
    """CVode cannot go on; the text is its own name of the reason."""


class Cvode:
    """The solver of one system of ``n`` states with ``n_roots`` root functions.

    ``states`` is the address of the states at the end of the last step, or of those asked for by ``at``.
    """

    def __init__(
        self,
        n: int,
        n_roots: int,
        rates: Function,
        roots: Function,
        tolerance: float,
        max_step: float,
    ) -> None:
        """Allocate; ``tolerance`` is relative, ``max_step`` in s. Raises FmuError where fmpy has no CVode."""
        s = _sundials()
        self._library = s
        self._tolerance = max(_SHARE * tolerance, LEAST_TOLERANCE)
        self._max_step = max_step
        self.n, self.n_roots = n, n_roots
        self._context = s.SUNContext()
        s.SUNContext_Create(s.SUN_COMM_NULL, byref(self._context))
        self._quiet = s.SUNErrHandlerFn(lambda *_: None)  # the reason is in what each call returns
        s.SUNContext_ClearErrHandlers(self._context)
        s.SUNContext_PushErrHandler(self._context, self._quiet, None)
        self._y, self._atol, self._dense = (s.N_VNew_Serial(n, self._context) for _ in range(3))
        self._matrix = s.SUNDenseMatrix(n, n, self._context)
        self._linear = s.SUNLinSol_Dense(self._y, self._matrix, self._context)
        self._memory: int | None = None
        data = s.N_VGetArrayPointer
        self._rates = s.CVRhsFn(lambda t, y, dy, _: rates(t, data(y), data(dy)))
        self._roots = s.CVRootFn(lambda t, y, g, _: roots(t, data(y), cast(g, c_void_p).value or 0))
        self._time = c_double()
        self.states: int = data(self._y)

    def start(self, t: float, states: int, nominals: int, stop: float | None) -> None:
        """Start at t [s] from the states at an address, with their nominal values; never go beyond ``stop`` [s].

        The absolute tolerance is, as the FMI standard has it, 0.01 times the relative one times the nominal value.
        """
        s, data = self._library, self._library.N_VGetArrayPointer
        memmove(data(self._y), states, 8 * self.n)
        absolute = (c_double * self.n).from_address(data(self._atol))
        for i, nominal in enumerate((c_double * self.n).from_address(nominals)):
            absolute[i] = 0.01 * self._tolerance * (abs(nominal) or 1.0)
        self.states = data(self._y)
        if self._memory is None:
            self._memory = s.CVodeCreate(_BDF, self._context)
            s.CVodeInit(self._memory, self._rates, t, self._y)
            s.CVodeRootInit(self._memory, self.n_roots, self._roots)
            s.CVodeSetLinearSolver(self._memory, self._linear, self._matrix)
            s.CVodeSetNoInactiveRootWarn(self._memory)
            s.CVodeSetMaxStep(self._memory, self._max_step)
        else:
            s.CVodeReInit(self._memory, t, self._y)
        s.CVodeSVtolerances(self._memory, self._tolerance, self._atol)
        if stop is not None:
            s.CVodeSetStopTime(self._memory, stop)

    def step(self, towards: float) -> Step:
        """Take one internal step; at the beginning ``towards`` [s] tells where it goes. Raises CvodeError."""
        s = self._library
        flag = s.CVode(self._memory, towards, self._y, byref(self._time), _ONE_STEP)
        if flag < 0:
            raise CvodeError(self._name(flag))
        self.states = s.N_VGetArrayPointer(self._y)
        return Step(self._time.value, flag == _ROOT)

    def at(self, t: float) -> int:
        """Return the address of the states at t [s], within the last step. Raises CvodeError."""
        s = self._library
        flag = s.CVodeGetDky(self._memory, t, 0, self._dense)
        if flag < 0:
            raise CvodeError(self._name(flag))
        return int(s.N_VGetArrayPointer(self._dense))

    def _name(self, flag: int) -> str:
        name: bytes = self._library.CVodeGetReturnFlagName(flag)
        return name.decode()

    def free(self) -> None:
        """Give the memory back."""
        s = self._library
        if self._memory is not None:
            s.CVodeFree(byref(c_void_p(self._memory)))
        s.SUNLinSolFree(self._linear)
        s.SUNMatDestroy(self._matrix)
        for vector in (self._y, self._atol, self._dense):
            s.N_VDestroy_Serial(vector)
        s.SUNContext_Free(byref(self._context))


@functools.cache
def _sundials() -> SimpleNamespace:
    """Return fmpy's interface to SUNDIALS, and the functions that it leaves out."""
    try:
        from fmpy import sundials
        from fmpy.sundials.libraries import sundials_core, sundials_cvode
    except OSError as error:
        raise FmuError(
            "is for Model Exchange only, which needs the native library of the engine, or the solver CVode, which fmpy "
            "has not for this computer; install a C compiler: pip install 'wiper-cosim[build]'"
        ) from error
    names = SimpleNamespace(**vars(sundials))
    vector, context = sundials.N_Vector, sundials.SUNContext
    for library, name, result, arguments in (
        (sundials_cvode, "CVodeGetDky", c_int, (c_void_p, c_double, c_int, vector)),
        (sundials_cvode, "CVodeSetStopTime", c_int, (c_void_p, c_double)),
        (sundials_cvode, "CVodeGetReturnFlagName", c_char_p, (c_int,)),
        (sundials_core, "N_VGetArrayPointer", c_void_p, (vector,)),
        (sundials_core, "SUNContext_ClearErrHandlers", c_int, (context,)),
        (sundials_core, "SUNContext_Free", c_int, (c_void_p,)),
        (sundials_core, "SUNLinSolFree", c_int, (c_void_p,)),
        (sundials_core, "SUNMatDestroy", None, (c_void_p,)),
    ):
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
        setattr(names, name, function)
    return names

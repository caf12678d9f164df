"""Whatever the signals are, a comparison gives a document or says in words why not."""

from __future__ import annotations

import json
import warnings
from pathlib import Path

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cosim.assessment import Trace
from cosim.comparison import Options, compare
from cosim.errors import InputError
from cosim.measurement import Measurement
from cosim.measurement._measurement import UNITS, frame_of
from cosim.measurement._read import _meta

Signals = tuple[np.ndarray, np.ndarray, np.ndarray]
VALUES = st.one_of(st.just(0.0), st.floats(-1e3, 1e3), st.floats(-1e29, 1e29))
SIGNALS = st.integers(2, 60).flatmap(
    lambda n: st.tuples(
        st.lists(st.floats(1e-2, 3), min_size=n, max_size=n).map(np.cumsum),
        arrays(np.float64, n, elements=VALUES),
        arrays(np.float64, n, elements=VALUES),
    )
)


@settings(max_examples=80, deadline=None)
@given(
    SIGNALS,
    SIGNALS,
    st.sampled_from(["correlation", "onset", "angle", "none"]),
    st.sampled_from(["none", "moving_average", "zero_phase"]),
)
def test_no_signals_end_in_a_traceback(a: Signals, b: Signals, align: str, smoothing: str) -> None:
    run = Trace("r", a[0], {"p.tau_crank": a[1], "p.phi_crank": np.cumsum(np.abs(a[2]))})
    meta = _meta(Path("m.csv"), ".csv", "rad/s")
    meta["units"] = UNITS
    measurement = Measurement(frame_of({"time": b[0] - b[0][0], "torque": b[1], "speed": b[2]}), meta)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            found = compare(run, measurement, Options(align=align, smoothing=smoothing))  # type: ignore[arg-type]
        except InputError as error:
            assert str(error)
        else:
            json.dumps(found.to_dict(), allow_nan=False)

"""What a fit found as a parameter file for ``cosim run --params``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from cosim.calibration._equations import SUPPLY_DROP
from cosim.calibration._results import Fit
from cosim.scenario import write_parameters


def write_fit(
    found: Fit, path: Path, fixed: Mapping[str, tuple[float, str]] | None = None, component: str = "plant"
) -> dict[str, object]:
    """Write the parameters, and beside them how certain they are and how well they fit; return what is written.

    Local parameters have no one value: where there are several measurements, they stand under "local", and are not set.
    Nor is the supply's drop, which is none of the plant.

    Args:
        found: the fit.
        path: the file.
        fixed: value and unit of the parameters that the fit took as given and that are to be set with the others.
        component: the scenario's name of the plant.

    Raises:
        InputError: the file cannot be written.
    """
    fitted = [each for each, agreement in zip(found.data, found.agreements, strict=True) if not agreement.held_out]
    provenance = f"fitted to {', '.join(each.name for each in fitted)}"
    if not found.solved:
        provenance += f"; NOT CONVERGED: {found.limit}"
    if found.synthetic and "(synthetic)" not in provenance:
        provenance += " (synthetic)"
    entries: list[dict[str, object]] = []
    local: list[dict[str, object]] = []
    for each in found.estimates:
        entry: dict[str, object] = {
            "name": f"{component}.{each.name}",
            "value": each.value,
            "unit": each.unit,
            "standard_error": _finite(each.error),
            "start": each.start,
            "at_bound": each.at_bound,
            "provenance": provenance,
        }
        if each.name == SUPPLY_DROP:
            local.append(entry | {"name": each.name, "of": each.of or ", ".join(data.name for data in fitted)})
        elif each.of is None or len(fitted) == 1:
            entries.append(entry)
        else:
            local.append(entry | {"of": each.of, "provenance": f"fitted to {each.of}"})
    for name, (value, unit) in (fixed or {}).items():
        entry = {"name": f"{component}.{name}", "value": value, "unit": unit, "provenance": "given, not fitted"}
        if name != SUPPLY_DROP:
            entries.append(entry)
    spread = found.uncertainty
    more: dict[str, object] = {
        "local": local,
        "converged": found.solved,
        "limit": found.limit,
        "iterations": found.iterations,
        "synthetic": found.synthetic,
        "chi": spread.chi,
        "correlation": {"names": list(spread.names), "values": spread.correlation.tolist()},
        "directions": [
            {"coefficients": d.coefficients, "standard_error": _finite(d.error), "determined": d.determined}
            for d in spread.directions
        ],
        "undetermined": [direction.told() for direction in spread.undetermined],
        "agreement": [
            {
                "name": a.name,
                "source": data.source,
                "from_s": float(data.time[0]),
                "to_s": float(data.time[-1]),
                "current_rmse_a": a.current_rmse,
                "current_noise_a": a.noise,
                "torque_rmse_nm": a.torque_rmse,
                "samples": a.samples,
                "held_out": a.held_out,
            }
            for a, data in zip(found.agreements, found.data, strict=True)
        ],
        "notes": list(found.notes),
    }
    write_parameters(path, entries, more)
    return {"parameters": entries, **more}


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None

"""Stand-in data: workbooks in the supplier's layout, computed, and marked as such.

The eight conditions are runs of LinkagePlant with parameters that differ from its defaults, by default also with
another load law than the one that a fit assumes, so that a calibration meets a model that is not quite its own. Every
number here is an assumption [A] for want of the supplier's data; none is a measurement.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cosim.errors import InputError
from cosim.measurement._processing import moving_average
from cosim.measurement._supplier import SAMPLE_TIME
from cosim.measurement._workbook import LAST_ROW, SYNTHETIC_SHEET

if TYPE_CHECKING:
    from cosim.engine import Fmu

Array = NDArray[np.float64]
Told = Callable[[str], None]

_AVERAGE = 50
"""Samples that the logger averages for A_avg [A]."""
_HEADER = ["V_meas", "XYZ", "A_calc", None, None, None, "A_avg", None, None, "Tp", None, None, "Sp", None]


@dataclass(frozen=True)
class Conditions:
    """One workbook: glass ("Dry", "Wet"), motor ("Cold", "Warm"), speed ("LS", "HS")."""

    glass: str
    motor: str
    speed: str

    @property
    def title(self) -> str:
        """The name of the file, without its ending."""
        return f"{self.glass} Glass {self.motor} Motor {self.speed}"

    def parameters(self) -> dict[str, float]:
        """Return the plant's parameters [A]: friction falls on wet glass, resistance and efficiency rise with heat."""
        dry, cold, low = self.glass == "Dry", self.motor == "Cold", self.speed == "LS"
        return {
            "ext_load": 3.6 if dry else 2.5,
            "d_joint": 0.95 if dry else 0.80,
            "gear.eta_wg": 0.70 if cold else 0.73,
            "motor.R": (1.91 if cold else 2.25) * (1.0 if low else 0.8),
            "k_emf": 0.113 if low else 0.088,
        }


CONDITIONS = tuple(
    Conditions(glass, motor, speed) for glass in ("Dry", "Wet") for motor in ("Cold", "Warm") for speed in ("HS", "LS")
)


@dataclass(frozen=True)
class Errors:
    """What the instruments add: standard deviations, an offset and a drift of the current, steps of the converters."""

    current_noise: float = 0.03
    current_offset: float = 0.01
    current_drift: float = 3e-4
    current_step: float = 0.005
    voltage_noise: float = 0.03
    voltage_step: float = 0.01
    supply: float = 24.4
    supply_resistance: float = 0.08
    """Volts of the source at no load, and Ohms up to the meter."""


def synthesize(
    folder: Path,
    plant: Fmu,
    *,
    seed: int = 1,
    rows: int = LAST_ROW - 1,
    naive_load: bool = True,
    errors: Errors | None = None,
    told: Told | None = None,
) -> list[Path]:
    """Write the eight workbooks; the same arguments give the same numbers.

    Args:
        folder: where to; it is made if it is not there.
        plant: the FMU LinkagePlant.
        seed: of the noise.
        rows: samples of 2 ms in each workbook, at most 50,000.
        naive_load: whether the load follows the source's naive law instead of equation 3.1.
        errors: of the instruments.
        told: is given the name of each file before it is made.

    Raises:
        InputError: ``rows`` is out of range, or a file cannot be written.
    """
    if not 1000 <= rows <= LAST_ROW - 1:
        raise InputError(f"{rows} rows; a workbook can have from 1000 to {LAST_ROW - 1}")
    errors = errors or Errors()
    paths = []
    for number, conditions in enumerate(CONDITIONS):
        path = folder / f"{conditions.title}.xlsx"
        if told is not None:
            told(path.name)
        rng = np.random.default_rng((seed, number))
        parameters = conditions.parameters() | {"naive_load": naive_load}
        before = int(rng.integers(300, 600))
        current, voltage = _run(plant, parameters, errors, rows - before)
        columns = _seen(current, voltage, before, errors, rng)
        try:
            folder.mkdir(parents=True, exist_ok=True)
            _write(path, columns, _lines(parameters, errors), _about(conditions, parameters, errors, seed))
        except OSError as error:
            raise InputError(f"cannot be written: {error.strerror or error}", file=path) from error
        paths.append(path)
    return paths


def _run(plant: Fmu, parameters: dict[str, float], errors: Errors, count: int) -> tuple[Array, Array]:
    """Current [A] and voltage [V] at the motor's meter from the start on, ``count`` samples each.

    The voltage falls with the current: simulated at the unloaded voltage first, then at that which the current leaves.
    """
    from cosim.engine import Channel, Component, System, simulate

    stop = (count - 1) * SAMPLE_TIME
    time = SAMPLE_TIME * np.arange(count)
    voltage = np.full(count, errors.supply)
    current = np.zeros(count)
    for _ in range(3):
        channels = [
            Channel(("plant", "duty"), [0.0], [1.0]),
            Channel(("plant", "v_supply"), time.tolist(), voltage.tolist(), linear=True),
        ]
        values = {name: bool(value) if name == "naive_load" else value for name, value in parameters.items()}
        system = System([Component("plant", plant, dict(values))], channels=channels)
        result = simulate(system, stop=stop, output_interval=SAMPLE_TIME, tolerance=1e-6)
        current = np.asarray(result.columns["plant.i_motor"], dtype=np.float64)[:count]
        voltage = errors.supply - errors.supply_resistance * current
    return current, voltage


def _seen(current: Array, voltage: Array, before: int, errors: Errors, rng: np.random.Generator) -> dict[str, Array]:
    """The columns as the logger writes them: the motor stands for ``before`` samples."""
    count = before + len(current)
    index = np.arange(count, dtype=np.float64)
    true_current = np.concatenate((np.zeros(before), current))
    true_voltage = np.concatenate((np.full(before, errors.supply), voltage))
    drift = errors.current_offset + errors.current_drift * index * SAMPLE_TIME
    noisy = true_current + drift + errors.current_noise * rng.standard_normal(count)
    sampled = errors.current_step * np.round(noisy / errors.current_step)
    volts = true_voltage + errors.voltage_noise * rng.standard_normal(count)
    return {
        "A": np.round(errors.voltage_step * np.round(volts / errors.voltage_step), 6),
        "B": index,
        "C": np.round(sampled, 6),
        "G": np.round(moving_average(sampled, _AVERAGE), 6),
    }


def _lines(parameters: dict[str, float], errors: Errors) -> tuple[tuple[float, float], tuple[float, float]]:
    """Tp and Sp as a supplier would find them for its motor: current and speed [rpm] over the steady torque.

    From k i = torque / (n eta) + friction and V = R i + k n w, with the friction of the no-load current.
    """
    k, resistance, eta, ratio = parameters["k_emf"], parameters["motor.R"], parameters["gear.eta_wg"], 73.0
    slope, no_load = 1.0 / (k * ratio * eta), 0.58
    rpm = 60.0 / (2.0 * math.pi)
    total = resistance + errors.supply_resistance
    line = (round(slope, 5), no_load)
    return line, (
        round(-rpm * total * slope / (k * ratio), 5),
        round(rpm * (errors.supply - total * no_load) / (k * ratio), 4),
    )


def _about(conditions: Conditions, parameters: dict[str, float], errors: Errors, seed: int) -> list[tuple[str, object]]:
    return [
        ("SYNTHETIC DATA", "computed by cosim measurements synthesize; this is no measurement"),
        ("conditions", conditions.title),
        ("model", "WiperDrive.Systems.LinkagePlant at full duty"),
        *parameters.items(),
        *asdict(errors).items(),
        ("seed", seed),
    ]


def _write(
    path: Path,
    columns: dict[str, Array],
    lines: tuple[tuple[float, float], tuple[float, float]],
    about: list[tuple[str, object]],
) -> None:
    import openpyxl

    book = openpyxl.Workbook(write_only=True)
    book.properties.title = "SYNTHETIC DATA: computed, not measured"
    sheet = book.create_sheet("Data")
    sheet.append(_HEADER)
    for row in _rows(columns, lines):
        sheet.append(row)
    note = book.create_sheet(SYNTHETIC_SHEET)
    for entry in about:
        note.append(list(entry))
    book.save(path)


def _rows(columns: dict[str, Array], lines: tuple[tuple[float, float], tuple[float, float]]) -> Iterator[list[object]]:
    texts = [columns[letter].tolist() for letter in "ABCG"]
    for k, (volts, index, each, average) in enumerate(zip(*texts, strict=True)):
        tp, sp = (lines[0][k], lines[1][k]) if k < 2 else (None, None)
        yield [volts, index, each, None, None, None, average, None, None, tp, None, None, sp, None]

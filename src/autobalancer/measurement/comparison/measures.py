"""The measures of a run from what was measured, as far as it suffices, and the same of the run as the sensors would see it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.measurement.comparison.pairs import Pair, sensor_of
from autobalancer.random_numbers import generator
from autobalancer.results.measure import needed
from autobalancer.results.measure_table import MEASURES
from autobalancer.results.recorded import Balls, Bins, Recorded
from autobalancer.results.recorded_of import bins_of, critical_speed_of

Floats = NDArray[np.float64]
DRAWS = 20  # of the noise
FLAT = 0.1  # sine of the angle between two sensors, below which they count as one
OF_REST = ("final_ball_angle_to_unbalance",)  # needs an unbalance, which a film does not see


class Row(NamedTuple):
    """One measure: of what, measured, of the run as the sensors see it, and one standard deviation by their noise; SI."""

    name: str
    unit: str
    of: str
    measured: float
    simulated: float
    deviation: float


def measure_rows(
    run: xr.Dataset, measured: xr.Dataset, found: list[Pair], seed: int, turned: xr.Dataset | None
) -> tuple[list[Row], list[str]]:
    """The measures that can be computed from the pairs, and why the others cannot.

    ``turned`` has the measured speed over its time, held before the first pulse and after the last; without a tacho it is taken
    to be that of the run.
    """
    if found[0].measured.unit == "rad":
        return _of_film(run, measured, found, seed)
    place = str(run.attrs.get("reference_station", ""))
    sensors = [sensor_of(measured[pair.measured.name]) for pair in found]
    here = [k for k, one in enumerate(sensors) if one.quantity == "displacement" and one.place in ("", place)]
    angles = np.array([sensors[k].angle for k in here])
    if len(here) < 2 or np.abs(np.sin(angles - angles[0])).max() < FLAT:
        return [], [
            f"no measures of the deflection: they need displacements in two directions at the reference station {place!r}"
        ]
    across = np.linalg.pinv(np.column_stack([np.cos(angles), np.sin(angles)]))
    time = found[here[0]].measured.time
    of_run = np.interp(time, run["time"].values, run["speed"].values)
    own = of_run if turned is None else np.interp(time, turned["time"].values, turned["speed"].values)

    def recorded(values: list[Floats], seen: bool) -> Recorded:
        x, y = across @ np.array(values)
        speed = own if seen else of_run
        data = xr.Dataset({"deflection": ("time", np.hypot(x, y)), "speed": ("time", speed)}, {"time": time})
        return Recorded(float(time[-1]), True, critical_speed_of(run), bins_of(data))

    rows = _rows([found[k] for k in here], recorded, "bins", seed)
    return rows, ["no measures of balls, supports and residual unbalance: they are not in signals of displacement"]


def _of_film(run: xr.Dataset, measured: xr.Dataset, found: list[Pair], seed: int) -> tuple[list[Row], list[str]]:
    """Of the motion of the balls; frames in which one was not seen are bridged."""
    time = np.asarray(measured["time"].values, np.float64)
    if time.size < 2:
        return [], ["no measures: one picture says where balls are, and not how they move"]
    speed = np.interp(time, run["time"].values, run["speed"].values)

    def recorded(values: list[Floats], _seen: bool) -> Recorded:
        angle = np.array(
            [np.interp(time, pair.measured.time, np.unwrap(one)) for pair, one in zip(found, values, strict=True)]
        ).T
        rate = np.gradient(angle, time, axis=0)
        empty = Bins(*[np.zeros(0)] * 6)
        balls = Balls(float(time[0]), time, speed, angle, rate)
        return Recorded(float(time[-1]), True, critical_speed_of(run), empty, balls)

    return _rows(found, recorded, "balls", seed), ["no measures of the deflection: a film of balls does not show it"]


def _rows(found: list[Pair], recorded: Callable[[list[Floats], bool], Recorded], known: str, seed: int) -> list[Row]:
    """Of the measures that need nothing else than what is ``known``; without deviation where a sensor states none.

    ``recorded`` is told whether the values are the measured ones.
    """
    random = generator(seed)
    stated = all(np.isfinite(pair.measured.deviation).any() for pair in found)
    true = recorded([pair.measured.values - (pair.shifted - pair.simulated) for pair in found], True)
    draws = []
    for _ in range(DRAWS):
        noise = [np.nan_to_num(pair.measured.deviation) * random.standard_normal(pair.simulated.size) for pair in found]
        draws.append(recorded([pair.simulated + part for pair, part in zip(found, noise, strict=True)], False))
    rows = []
    for measure in MEASURES:
        if set(needed(measure)) != {known} or measure.name in OF_REST:
            continue
        seen = np.array([np.atleast_1d(measure.of(draw)) for draw in draws], np.float64)
        values = np.atleast_1d(measure.of(true))
        for k, value in enumerate(values):
            several = [found[k].measured.name] if measure.along else [""]
            known_draws = seen[:, k][np.isfinite(seen[:, k])]
            mean = float(known_draws.mean()) if known_draws.size > DRAWS // 2 else math.nan
            spread = float(known_draws.std(ddof=1)) if stated and known_draws.size > DRAWS // 2 else math.nan
            rows.append(Row(measure.name, measure.unit, several[0], float(value), mean, spread))
    return rows


def measure_table(rows: list[Row]) -> xr.Dataset:
    """Rows as arrays over ``measure``."""

    def words(texts: list[str]) -> NDArray[np.object_]:
        return np.array(texts, dtype=object)

    return xr.Dataset(
        {
            "measured_value": ("measure", np.array([row.measured for row in rows], np.float64)),
            "simulated_value": ("measure", np.array([row.simulated for row in rows], np.float64)),
            "value_deviation": ("measure", np.array([row.deviation for row in rows], np.float64)),
            "measure_of": ("measure", words([row.of for row in rows])),
            "measure_unit": ("measure", words([row.unit for row in rows])),
        },
        {"measure": words([row.name for row in rows])},
    )

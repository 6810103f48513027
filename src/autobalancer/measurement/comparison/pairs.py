"""What was measured beside what a run gives in its place, sample by sample."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from autobalancer.errors import QuestionError
from autobalancer.measurement.sensors import ORDER, Sensor, at_samples, motion, place_seen, places_of
from autobalancer.random_numbers import generator
from autobalancer.results.measure_table import MEASURES, needed
from autobalancer.results.recorded import Balls, Bins, Recorded
from autobalancer.results.run_arrays import bins_of, critical_speed_of
from autobalancer.results.series import wrapped
from autobalancer.results.signals import Signals

Floats = NDArray[np.float64]
WRONG = 100.0  # ratio of sizes from which on a unit is probably wrong


@dataclass(frozen=True, eq=False)
class Pair:
    """One channel or ball, measured and simulated, over the times of the measurement.

    Attributes
    ----------
    measured
        With its standard deviations.
    simulated
        SI; angles are those within half a turn of the measured ones.
    free_offset
        Whether the zero of the sensor is not known, so that a mean deviation says nothing.
    place
        Of the run, with which it is compared; empty where it has one only, and of balls.
    """

    measured: Stated
    simulated: Floats
    free_offset: bool = False
    place: str = ""

    @property
    def shifted(self) -> Floats:
        """Simulated, with the mean of the measurement where the zero of the sensor is not known."""
        offset = float((self.measured.values - self.simulated).mean()) if self.free_offset else 0.0
        return np.asarray(self.simulated + offset, np.float64)


def pairs(run: xr.Dataset, measured: xr.Dataset, dense: bool = True) -> list[Pair]:
    """All channels or balls of a measurement with what the run has in their place.

    Parameters
    ----------
    run
        With samples; the times of the measurement are those of the run.
    measured
        Signals, or ball angles of a film.
    dense
        Whether samples of the run are anywhere; otherwise they are at the times of the measurement.

    Raises
    ------
    QuestionError
        If a place is not in the run, or it has fewer balls.
    """
    pairs = stated(measured)
    if is_film(measured):
        return _of_balls(run, pairs)
    return [_of_channel(run, measured[pair.name], pair, dense) for pair in pairs]


def sensor_of(entry: xr.DataArray) -> Sensor:
    """The sensor that a channel is from."""
    direction = entry.attrs.get("direction", "")
    place = str(entry.attrs.get("place", ""))
    return Sensor(entry.attrs["quantity"], place, "x" if direction == "" else direction, str(entry.name))


def scale_doubt(pair: Pair) -> str:
    """What is said where measured and simulated differ by a factor that is probably one of units; else empty."""
    if pair.measured.unit == "rad":
        return ""
    sizes = [_size(values - values.mean() * pair.free_offset) for values in (pair.measured.values, pair.simulated)]
    return size_doubt(pair.measured.name, pair.measured.unit, sizes[0], sizes[1], "root mean square")


def size_doubt(name: str, unit: str, measured: float, simulated: float, what: str = "greatest") -> str:
    """The same of two sizes."""
    if measured < WRONG * simulated and simulated < WRONG * measured:
        return ""
    ratio = measured / simulated if simulated > 0.0 else np.inf
    factor = f"{ratio:.3g} times" if ratio > 1.0 else f"1/{1.0 / ratio:.3g} of" if ratio > 0.0 else "nothing beside"
    return (
        f"{name}: the measured signal ({what} {measured:.3g} {unit}) is {factor} the simulated one; is its unit right, such as "
        "mm for m?"
    )


def place_doubt(run: xr.Dataset, sensors: list[Sensor], names: list[str]) -> str:
    """What is said where sensors have no place and the run has several; else empty."""
    open_ones = [
        name for sensor, name in zip(sensors, names, strict=True) if not sensor.place and place_seen(run, sensor)
    ]
    if not open_ones:
        return ""
    many = len(open_ones) > 1
    return (
        f"{', '.join(open_ones)}: the measurement does not say where {'these were' if many else 'this was'} measured, so "
        f"{'they are' if many else 'it is'} compared with {run.attrs['reference_station']!r}, the reference station of the run; "
        f"it has {', '.join(dict.fromkeys(map(repr, places_of(run))))}"
    )


def _size(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _of_channel(run: xr.Dataset, entry: xr.DataArray, value: Stated, dense: bool) -> Pair:
    sensor = sensor_of(entry)
    between = dense or ORDER[sensor.quantity] > 0
    simulated = motion(run, sensor, value.time)(value.time) if between else at_samples(run, sensor, value.time)
    return Pair(value, simulated, sensor.quantity != "force", place_seen(run, sensor))


def _of_balls(run: xr.Dataset, values: list[Stated]) -> list[Pair]:
    if "ball_angle_in_rotor" not in run:
        raise QuestionError("the run has no samples of its balls; run it with save=Samples(count)")
    known, clock = run["ball_angle_in_rotor"].values.T, run["time"].values
    if len(known) < len(values):
        raise QuestionError(f"{len(values)} balls were measured; the run has {len(known)}")
    simulated = [[np.interp(value.time, clock, angle) for angle in known] for value in values]
    cost = np.array(
        [[np.abs(wrapped(s - value.values)).sum() for s in row] for value, row in zip(values, simulated, strict=True)]
    )
    twins = linear_sum_assignment(cost)[1]  # balls look alike
    return [
        Pair(value, np.asarray(value.values + wrapped(row[twin] - value.values), np.float64))
        for value, row, twin in zip(values, simulated, twins, strict=True)
    ]


# What a measurement states: every channel or ball with its values and their standard deviations.


ANGLE = "ball_angle"


class Stated(NamedTuple):
    """Values of one channel or ball at times (s) with one standard deviation of each, nan where not known; (time,)."""

    name: str
    unit: str
    time: Floats
    values: Floats
    deviation: Floats


def is_film(measured: xr.Dataset) -> bool:
    """Whether these are ball angles over time."""
    return ANGLE in measured and set(measured[ANGLE].dims) == {"time", "ball"}


def motions_of(measured: xr.Dataset) -> list[str]:
    """Names of the channels that a run has, too."""
    return [str(name) for name, entry in measured.data_vars.items() if entry.attrs.get("quantity") in ORDER]


def stated(measured: xr.Dataset) -> list[Stated]:
    """All channels of motions and forces, or the balls of a film where they were seen.

    Raises
    ------
    QuestionError
        If it is no such measurement.
    """
    if is_film(measured):
        return _balls(measured)
    if not isinstance(measured, Signals) or not motions_of(measured):
        raise QuestionError(
            "measured: give signals with a displacement, velocity, acceleration or force, from ab.measure.load_signals, "
            "or the ball angles of a film"
        )
    time = np.asarray(measured["time"].values, np.float64)
    return [
        Stated(
            name,
            str(measured[name].attrs["units"]),
            time,
            np.asarray(measured[name].values, np.float64),
            np.full(time.size, float(measured[name].attrs.get("uncertainty", np.nan))),
        )
        for name in motions_of(measured)
    ]


def _balls(measured: xr.Dataset) -> list[Stated]:
    time = np.asarray(measured["time"].values, np.float64)
    angles = np.asarray(measured[ANGLE].transpose("ball", "time").values, np.float64)
    sure, seen = np.full(angles.shape, np.nan), np.isfinite(angles)
    if (name := f"{ANGLE}_deviation") in measured:
        sure = measured[name].broadcast_like(measured[ANGLE]).transpose("ball", "time").values
    if "seen" in measured:
        seen &= measured["seen"].transpose("ball", "time").values.astype(bool)
    names = measured["ball"].values if "ball" in measured.coords else np.arange(1, len(angles) + 1)
    return [
        Stated(f"ball {name}", "rad", time[row], angle[row], deviation[row])
        for name, row, angle, deviation in zip(names, seen, angles, sure, strict=True)
    ]


# The measures of a run from what was measured, as far as it suffices, and the same of the run as the sensors would see
# it.


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
    run: xr.Dataset, measured: xr.Dataset, pairs: list[Pair], seed: int, turned: xr.Dataset | None
) -> tuple[list[Row], list[str]]:
    """The measures that can be computed from the pairs, and why the others cannot.

    ``turned`` has the measured speed over its time, held before the first pulse and after the last; without a tacho it is taken
    to be that of the run.
    """
    if pairs[0].measured.unit == "rad":
        return _of_film(run, measured, pairs, seed)
    place = str(run.attrs.get("reference_station", ""))
    sensors = [sensor_of(measured[pair.measured.name]) for pair in pairs]
    here = [k for k, sensor in enumerate(sensors) if sensor.quantity == "displacement" and sensor.place in ("", place)]
    angles = np.array([sensors[k].angle for k in here])
    if len(here) < 2 or np.abs(np.sin(angles - angles[0])).max() < FLAT:
        return [], [
            f"no measures of the deflection: they need displacements in two directions at the reference station {place!r}"
        ]
    across = np.linalg.pinv(np.column_stack([np.cos(angles), np.sin(angles)]))
    time = pairs[here[0]].measured.time
    of_run = np.interp(time, run["time"].values, run["speed"].values)
    own = of_run if turned is None else np.interp(time, turned["time"].values, turned["speed"].values)

    def recorded(values: list[Floats], seen: bool) -> Recorded:
        x, y = across @ np.array(values)
        speed = own if seen else of_run
        data = xr.Dataset({"deflection": ("time", np.hypot(x, y)), "speed": ("time", speed)}, {"time": time})
        return Recorded(float(time[-1]), True, critical_speed_of(run), bins_of(data))

    rows = _rows([pairs[k] for k in here], recorded, "bins", seed)
    return rows, ["no measures of balls, supports and residual unbalance: they are not in signals of displacement"]


def _of_film(run: xr.Dataset, measured: xr.Dataset, pairs: list[Pair], seed: int) -> tuple[list[Row], list[str]]:
    """Of the motion of the balls; frames in which one was not seen are bridged."""
    time = np.asarray(measured["time"].values, np.float64)
    if time.size < 2:
        return [], ["no measures: one picture says where balls are, and not how they move"]
    speed = np.interp(time, run["time"].values, run["speed"].values)

    def recorded(values: list[Floats], _seen: bool) -> Recorded:
        angle = np.array(
            [np.interp(time, pair.measured.time, np.unwrap(one)) for pair, one in zip(pairs, values, strict=True)]
        ).T
        rate = np.gradient(angle, time, axis=0)
        empty = Bins(*[np.zeros(0)] * 6)
        balls = Balls(float(time[0]), time, speed, angle, rate)
        return Recorded(float(time[-1]), True, critical_speed_of(run), empty, balls)

    return _rows(pairs, recorded, "balls", seed), ["no measures of the deflection: a film of balls does not show it"]


def _rows(pairs: list[Pair], recorded: Callable[[list[Floats], bool], Recorded], known: str, seed: int) -> list[Row]:
    """Of the measures that need nothing else than what is ``known``; without deviation where a sensor states none.

    ``recorded`` is told whether the values are the measured ones.
    """
    random = generator(seed)
    stated = all(np.isfinite(pair.measured.deviation).any() for pair in pairs)
    true = recorded([pair.measured.values - (pair.shifted - pair.simulated) for pair in pairs], True)
    draws = []
    for _ in range(DRAWS):
        noise = [np.nan_to_num(pair.measured.deviation) * random.standard_normal(pair.simulated.size) for pair in pairs]
        draws.append(recorded([pair.simulated + part for pair, part in zip(pairs, noise, strict=True)], False))
    rows = []
    for measure in MEASURES:
        if set(needed(measure)) != {known} or measure.name in OF_REST:
            continue
        seen = np.array([np.atleast_1d(measure.of(draw)) for draw in draws], np.float64)
        values = np.atleast_1d(measure.of(true))
        for k, value in enumerate(values):
            several = [pairs[k].measured.name] if measure.along else [""]
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

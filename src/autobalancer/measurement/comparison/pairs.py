"""What was measured beside what a run gives in its place, sample by sample."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from autobalancer.errors import QuestionError
from autobalancer.measurement.comparison.stated import Stated, is_film, stated
from autobalancer.measurement.sensors.motion import ORDER, at_samples, motion, place_seen, places_of
from autobalancer.measurement.sensors.sensor import Sensor
from autobalancer.results.series import wrapped

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
    found = stated(measured)
    if is_film(measured):
        return _of_balls(run, found)
    return [_of_channel(run, measured[one.name], one, dense) for one in found]


def sensor_of(entry: xr.DataArray) -> Sensor:
    """The sensor that a channel is from."""
    direction = entry.attrs.get("direction", "")
    place = str(entry.attrs.get("place", ""))
    return Sensor(entry.attrs["quantity"], place, "x" if direction == "" else direction, str(entry.name))


def at_the_end(run: xr.Dataset, measured: xr.Dataset) -> xr.Dataset:
    """A photograph, whose ball angles have no time, as a film of one picture at the end of the run; else as it is."""
    if "ball_angle" not in measured or set(measured["ball_angle"].dims) != {"ball"}:
        return measured
    kept = measured[[name for name in ("ball_angle", "ball_angle_deviation") if name in measured]]
    return kept.expand_dims(time=run["time"].values[-1:])


def together(run: xr.Dataset, measured: xr.Dataset) -> xr.Dataset:
    """The part of a measurement within the time of a run.

    Raises
    ------
    QuestionError
        If there are fewer than two samples of it, of a film or a photograph none.
    """
    t, known = measured["time"].values, run["time"].values
    inside = (t >= known[0] - 1e-9) & (t <= known[-1] + 1e-9)
    if inside.sum() < (1 if is_film(measured) else 2):
        raise QuestionError(
            f"the measurement is from {t[0]:.6g} s to {t[-1]:.6g} s, the run from {known[0]:.6g} s to {known[-1]:.6g} s; "
            "they have no time in common"
        )
    return measured.isel(time=inside)


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


def _of_channel(run: xr.Dataset, entry: xr.DataArray, one: Stated, dense: bool) -> Pair:
    sensor = sensor_of(entry)
    between = dense or ORDER[sensor.quantity] > 0
    simulated = motion(run, sensor, one.time)(one.time) if between else at_samples(run, sensor, one.time)
    return Pair(one, simulated, sensor.quantity != "force", place_seen(run, sensor))


def _of_balls(run: xr.Dataset, found: list[Stated]) -> list[Pair]:
    if "ball_angle_in_rotor" not in run:
        raise QuestionError("the run has no samples of its balls; run it with save=Samples(count)")
    known, clock = run["ball_angle_in_rotor"].values.T, run["time"].values
    if len(known) < len(found):
        raise QuestionError(f"{len(found)} balls were measured; the run has {len(known)}")
    simulated = [[np.interp(one.time, clock, angle) for angle in known] for one in found]
    cost = np.array(
        [[np.abs(wrapped(s - one.values)).sum() for s in row] for one, row in zip(found, simulated, strict=True)]
    )
    twins = linear_sum_assignment(cost)[1]  # balls look alike
    return [
        Pair(one, np.asarray(one.values + wrapped(row[twin] - one.values), np.float64))
        for one, row, twin in zip(found, simulated, twins, strict=True)
    ]

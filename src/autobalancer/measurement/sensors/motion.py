"""Motions and forces between the samples of a run: splines, and how far they can be trusted."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.interpolate import BSpline, make_interp_spline

from autobalancer.errors import QuestionError
from autobalancer.measurement.sensors.sensor import Sensor

Floats = NDArray[np.float64]
DEGREE = 5
ORDER = {"displacement": 0, "velocity": 1, "acceleration": 2, "force": 0}  # derivatives in time
PER_TURN = 16  # samples in a turn of the rotor at least
ALLOWED = (
    0.01  # of the signal: what half of the samples may be wrong by; of all of them it is less by 2^(6 - derivatives)
)
WINDOWS = 20  # in each of which that is asked
QUIET = 1e-3  # of the whole signal: a window with less is not judged
STILL = 1e-6  # of the motion across: a signal with less, such as rounding errors, is not judged


@dataclass(frozen=True)
class Motion:
    """A quantity along a direction between the samples of a run, and its spline."""

    spline: BSpline

    def __call__(self, time: Floats) -> Floats:
        """At these times, s."""
        return np.asarray(self.spline(time), np.float64)


def sampled(run: xr.Dataset) -> Floats:
    """Times of the samples of a run, s.

    Raises
    ------
    QuestionError
        If it kept too few of them.
    """
    times = np.asarray(run["time"].values, np.float64) if "rotor_angle" in run else np.zeros(0)
    if times.size < 4 * DEGREE:
        raise QuestionError(
            f"record: the run kept {times.size} samples over time; run it with save=Samples(count), "
            f"with at least {PER_TURN} samples in each turn of the rotor"
        )
    return times


def motion(run: xr.Dataset, sensor: Sensor, time: Floats) -> Motion:
    """What a sensor would see, without what is wrong with the sensor itself.

    Raises
    ------
    QuestionError
        If the place is not in the run, or the samples between ``time[0]`` and ``time[-1]`` are too far apart.
    """
    times = sampled(run)
    x, y = _vectors(run, sensor)
    values = x * math.cos(sensor.angle) + y * math.sin(sensor.angle)
    order = ORDER[sensor.quantity]
    spline = _spline(times, values, order)
    first, last = np.searchsorted(times, (time[0], time[-1]))
    inside = slice(max(int(first) - 1, 0), int(last) + 2)
    _check_turns(run, times, inside)
    across = _spline(times, y * math.cos(sensor.angle) - x * math.sin(sensor.angle), order)(times)
    if spline(times).std() > STILL * across.std():
        _check_halves(times, values, spline, order, inside, sensor.channel)
    return Motion(spline)


def _spline(times: Floats, values: Floats, order: int) -> BSpline:
    found = make_interp_spline(times, values, k=DEGREE)
    return found.derivative(order) if order else found


def at_samples(run: xr.Dataset, sensor: Sensor, time: Floats) -> Floats:
    """A displacement or force at samples of the run, as they are; ``time`` (s) is among their times."""
    x, y = _vectors(run, sensor)
    rows = np.searchsorted(run["time"].values, time - 1e-12 * (1.0 + abs(time)))
    return np.asarray((x * math.cos(sensor.angle) + y * math.sin(sensor.angle))[rows], np.float64)


def _vectors(run: xr.Dataset, sensor: Sensor) -> tuple[Floats, Floats]:
    """x and y of the place over the samples."""
    if sensor.quantity == "force":
        names, prefix, dimension = list(map(str, run["support"].values)), "support_force_", "support"
        if not sensor.place and len(names) == 1:
            return run[f"{prefix}x"].values[:, 0], run[f"{prefix}y"].values[:, 0]
        if sensor.place in names:
            row = names.index(sensor.place)
            return run[f"{prefix}x"].values[:, row], run[f"{prefix}y"].values[:, row]
        raise QuestionError(_unknown(sensor, names, dimension))
    if not sensor.place:
        return run["x"].values, run["y"].values
    for dimension in ("station", "plane"):
        names = list(map(str, run[dimension].values)) if f"{dimension}_x" in run else []
        if sensor.place in names:
            row = names.index(sensor.place)
            return run[f"{dimension}_x"].values[:, row], run[f"{dimension}_y"].values[:, row]
    raise QuestionError(_unknown(sensor, places_of(run), "place"))


def places_of(run: xr.Dataset) -> list[str]:
    """Names of the stations and planes whose motion the samples of a run have."""
    return [str(n) for dimension in ("station", "plane") if f"{dimension}_x" in run for n in run[dimension].values]


def place_seen(run: xr.Dataset, sensor: Sensor) -> str:
    """The place of the run that a sensor sees: its own, without one the reference station; empty where there is one only."""
    if sensor.place or sensor.quantity == "force" or len(places_of(run)) < 2:
        return sensor.place
    return str(run.attrs.get("reference_station", ""))


def _unknown(sensor: Sensor, names: list[str], what: str) -> str:
    known = ", ".join(map(repr, dict.fromkeys(names)))
    given = f"its place is {sensor.place!r}" if sensor.place else "it has no place"
    if not known:
        return f"sensor {sensor.channel!r}: {given}, but no {what} of the run has a name; leave it out"
    return f"sensor {sensor.channel!r}: {given}; the {what}s of the run are {known}; give it one of these"


def _check_turns(run: xr.Dataset, times: Floats, inside: slice) -> None:
    speed = float(np.abs(run["speed"].values[inside]).max())
    step = float(np.diff(times[inside]).max())
    if speed * step > 2.0 * math.pi / PER_TURN:
        count = math.ceil(float(np.ptp(times)) * speed * PER_TURN / (2.0 * math.pi)) + 1
        raise QuestionError(
            _too_few(times, count, f"{2.0 * math.pi / (speed * step):.3g} samples in a turn of the rotor")
        )


def _check_halves(times: Floats, values: Floats, whole: BSpline, order: int, inside: slice, name: str) -> None:
    """Whether every second sample would nearly do, in every part of the record."""
    half = _spline(times[::2], values[::2], order)
    odd = times[inside][1:-1]
    odd = odd[(odd > times[2 * DEGREE]) & (odd < times[-1 - 2 * DEGREE])]
    if odd.size < WINDOWS:
        return
    true = whole(odd)
    off, size = half(odd) - true, true - true.mean()
    parts = np.array_split(np.arange(odd.size), WINDOWS)
    wrong = np.array([np.sqrt(np.mean(off[part] ** 2)) for part in parts])
    great = np.array([np.sqrt(np.mean(size[part] ** 2)) for part in parts])
    judged = great > QUIET * np.sqrt(np.mean(size**2))
    if not judged.any():
        return
    share = float((wrong[judged] / great[judged]).max())
    if share > ALLOWED:
        more = (share / ALLOWED) ** (1.0 / (DEGREE + 1 - order))
        why = f"what {name} sees changes too fast between them"
        raise QuestionError(_too_few(times, math.ceil(1.1 * more * times.size), why))


def _too_few(times: Floats, count: int, why: str) -> str:
    return (
        f"record: the run kept {times.size} samples, too few: {why}; "
        f"simulate it with save=Samples({count}) (--samples {count}) or more, for {np.ptp(times):g} s"
    )

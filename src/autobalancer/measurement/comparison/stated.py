"""What a measurement states: every channel or ball with its values and their standard deviations."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.measurement.sensors.motion import ORDER
from autobalancer.results.signals.signals import Signals

Floats = NDArray[np.float64]
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

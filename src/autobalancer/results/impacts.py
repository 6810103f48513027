"""Impacts of a run as plain arrays, and what they say of its noise."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.kernels.measures.limits import LAST, OF_IMPACTS
from autobalancer.results.series import plain

Floats = NDArray[np.float64]


class Impacts(NamedTuple):
    """Impacts in the order of time, (I,) each."""

    time: Floats  # s
    speed: Floats  # m/s, at which the bodies approached
    lost: Floats  # J
    impulse: Floats  # N s
    ball: NDArray[np.int64]  # counted from 1
    partner: NDArray[np.int64]  # the other ball, 0 a partition, -1 a wall of the race


VARIABLES = {
    "impact_speed": "speed",
    "impact_loss": "lost",
    "impact_impulse": "impulse",
    "impact_ball": "ball",
    "impact_partner": "partner",
}


def impacts_of(run: xr.Dataset) -> Impacts | None:
    """The impacts that a run noted; None where nothing could touch, or it noted none."""
    if "impact_time" not in run:
        return None
    return Impacts(run["impact_time"].values, **{name: run[kept].values for kept, name in VARIABLES.items()})


def noise_of(found: Impacts, end: float) -> Floats:
    """Number, mean speed (m/s), power (W), greatest impulse (N s); rate (1/s) and power at the end of a run of ``end`` seconds.

    They are in the order of kernels/measures/limits.py, from COUNT to LATE_POWER.
    """
    from autobalancer.kernels.measures.impacts import impact_measures

    measured = np.empty(OF_IMPACTS)
    time, speed, lost, impulse = map(plain, (found.time, found.speed, found.lost, found.impulse))
    impact_measures(time, speed, lost, impulse, found.time.size, end - LAST * end, end, measured)
    return measured

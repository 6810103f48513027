"""Impacts of a run as plain arrays, and what they say of its noise."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Impacts(NamedTuple):
    """Impacts in the order of time, (I,) each."""

    time: Floats  # s
    speed: Floats  # m/s, at which the bodies approached
    lost: Floats  # J
    impulse: Floats  # N s
    ball: NDArray[np.int64]  # counted from 1
    partner: NDArray[np.int64]  # the other ball, 0 a partition, -1 a wall of the race

    def rate(self, begin: float, end: float) -> float:
        """Impacts a second between two times, 1/s."""
        return float(np.count_nonzero(self._between(begin, end)) / (end - begin)) if end > begin else np.nan

    def power(self, begin: float, end: float) -> float:
        """Power that they dissipate between two times, W."""
        return float(self.lost[self._between(begin, end)].sum() / (end - begin)) if end > begin else np.nan

    @property
    def mean_speed(self) -> float:
        """m/s; nan without impacts."""
        return float(self.speed.mean()) if self.speed.size else np.nan

    def _between(self, begin: float, end: float) -> NDArray[np.bool_]:
        return (self.time >= begin) & (self.time <= end)


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

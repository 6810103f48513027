"""The fluid at the orbit over time, as a table."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy.interpolate import PchipInterpolator

from autobalancer.flow.annulus import Floats


@dataclass(frozen=True)
class SpinUp:
    """Angular velocity of the fluid at the orbit over time, for balls on a rotor whose speed is prescribed.

    The flow does not depend on the balls, so one table serves all runs with this profile.

    Parameters
    ----------
    times
        Ascending, s; (time,).
    angular_velocity
        Of the fluid at the orbit in space, rad/s; (time,).
    """

    times: Floats
    angular_velocity: Floats

    def at(self, times: Floats | float) -> Floats:
        """Angular velocity at ``times``, rad/s: monotonic cubics between the entries, constant outside."""
        inside = np.clip(times, self.times[0], self.times[-1])
        return np.asarray(PchipInterpolator(self.times, self.angular_velocity)(inside), np.float64)


def spin_up(flow: xr.Dataset) -> SpinUp:
    """The table of ``flow``, a result of :func:`annulus_flow`."""
    return SpinUp(flow["time"].values.copy(), flow["fluid_speed"].values.copy())


def decay_time(times: Floats, lag: Floats, start: float) -> float:
    """Time from ``start`` until the lag has fallen to 1/e of what it was then for good, s; nan if it has not by the end."""
    if not start < times[-1]:
        return float("nan")
    size = np.abs(lag)
    goal = float(np.interp(start, times, size)) / math.e
    above = np.flatnonzero((size > goal) & (times >= start))
    if goal == 0.0 or above.size == 0 or above[-1] + 1 == size.size:
        return float("nan")
    i = int(above[-1])
    part = (size[i] - goal) / (size[i] - size[i + 1])
    return float(times[i] + part * (times[i + 1] - times[i]) - start)

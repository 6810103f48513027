"""The paths that an orbit is drawn from: last revolutions or samples of each place on the axis."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.plots.run.places import places
from autobalancer.plots.run.static import static_part
from autobalancer.results.drawn.motion import Complexes, Floats, cubic


class OrbitPath(NamedTuple):
    """Moments of one place as they were kept; the deflection is about the static position."""

    name: str
    time: Floats
    speed: Floats  # rad/s
    rotor_angle: Floats  # rad
    deflection: Complexes  # m, in the rotor
    static: complex  # m, in space

    def between(self, *, in_space: bool) -> Complexes:
        """The path with seven points between two samples, a cubic in the rotor."""
        count = self.time.size
        fine = np.interp(np.linspace(0.0, count - 1.0, 8 * (count - 1) + 1), np.arange(count), self.time)
        path = cubic(fine, self.time, self.deflection, np.gradient(self.deflection, self.time))
        if not in_space:
            return path
        angle = cubic(fine, self.time, self.rotor_angle, self.speed)
        return np.asarray(path * np.exp(1j * angle))


def orbit_paths(run: xr.Dataset, start: float | None, end: float | None) -> list[OrbitPath]:
    """The moments to draw of each place: the last revolutions, else samples.

    Raises
    ------
    QuestionError
        If the run has neither in the interval.
    """
    for prefix, dimension in (("turn_", "turn"), ("", "time")):
        needed = [f"{prefix}{name}" for name in ("time", "speed", "x", "y")]
        if not all(name in run for name in needed) or run[needed[0]].size < 2:
            continue
        time = np.asarray(run[needed[0]].values, np.float64)
        first, last = float(time[0]), float(time[-1])
        begin = start if start is not None else first if prefix else last - 0.05 * (last - first)
        final = last if end is None else end
        if prefix and (begin < first - 1e-9 or final > last + 1e-9) and "time" in run:
            continue  # the samples reach farther
        inside = np.flatnonzero((time >= begin - 1e-9) & (time <= final + 1e-9))
        if inside.size < 2:
            raise QuestionError(
                f"from {begin:g} s to {final:g} s: fewer than two samples; the run has {first:g} s to {last:g} s"
            )
        return _paths(run.isel({dimension: inside}), prefix)
    raise QuestionError("the run has no samples; save Samples() or LastRevolutions() with simulate(..., save=...)")


def _paths(part: xr.Dataset, prefix: str) -> list[OrbitPath]:
    time, speed = (np.asarray(part[f"{prefix}{name}"].values, np.float64) for name in ("time", "speed"))
    if f"{prefix}rotor_angle" in part:
        angle = np.asarray(part[f"{prefix}rotor_angle"].values, np.float64)
    else:  # measured: from the speed, counted from the first sample
        angle = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))])
    found = []
    for place in places(part, prefix):
        static = static_part(part, time, angle, place.deflection, float(time[-1]), samples=time.size)
        moved = (place.deflection - static) * np.exp(-1j * angle)
        found.append(OrbitPath(place.name, time, speed, angle, np.asarray(moved), static))
    return found

"""What races off the axis leave at the end of a run, in words."""

from __future__ import annotations

import math

import xarray as xr

from autobalancer.assembly.off_center import off_center
from autobalancer.assembly.places import Places
from autobalancer.assembly.system import Assembly
from autobalancer.kernels.measures.limits import FASTEST
from autobalancer.results.number_text import length_text
from autobalancer.results.verdict.rule import LIMITS

MATTERS, _ = LIMITS[0]
"""Of the greatest vibration without balls: a smaller eccentricity still leaves the machine balanced."""


def eccentricity_text(places: Places, assembly: Assembly, run: xr.Dataset, speed: float) -> str:
    """The residual of the races off the axis at the last speed (rad/s); empty without balls.

    Of races whose eccentricity is not given, only where a typical one matters beside the vibration without balls.
    """
    if not 0.0 < abs(speed) < FASTEST:
        return ""
    found = off_center(places, assembly.balls, speed)
    if found is None or not found.sentence:
        return ""
    if not any(plane.given and plane.eccentricity > 0.0 for plane in found.planes):
        without = run["vibration_without_balls"].values if "vibration_without_balls" in run else [math.nan]
        if not found.greatest >= MATTERS * max(without):
            return ""
        size = length_text(found.greatest)
        return f"race eccentricity: not given; a typical {size} would leave that much vibration (see check)"
    return f"race eccentricity: {found.sentence}"

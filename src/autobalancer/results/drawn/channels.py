"""How wide pictures draw the races of resolved balls."""

from __future__ import annotations

import tomllib

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.units import argument


def resolved_widths(run: xr.Dataset) -> NDArray[np.float64]:
    """From the outer to the inner wall, m, for each ball; 0 for guided balls, which never leave the outer one."""
    widths = np.zeros(run.sizes.get("ball", 0))
    if "ball_gap" not in run:
        return widths
    for b, balancer in enumerate(tomllib.loads(run.attrs.get("machine", "")).get("balancers", []), 1):
        for r, race in enumerate(balancer.get("races", []), 1):
            if "resolved" in race and "width" in race:
                here = (run["balancer"].values == b) & (run["race"].values == r)
                widths[here] = argument("width", race["width"], "m")
    return widths

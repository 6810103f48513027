"""Sizes of the chambers of a run: from its attributes, else as large as where its balls have been."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr


@dataclass(frozen=True)
class Chamber:
    """A cylinder around the rotor's axis: radius and depth (m), place of its middle along the axis (m)."""

    radius: float
    depth: float
    place: float = 0.0


def chambers_of(run: xr.Dataset) -> list[Chamber]:
    """The chambers, in their order.

    Attributes ``chamber_radius``, ``chamber_depth`` and ``chamber_place`` of the run count. Without them a chamber is taken
    as what its balls have reached, which is exact for the radius once a ball has been at the race.
    """
    if "chamber_radius" in run.attrs:
        sizes = [np.atleast_1d(run.attrs[f"chamber_{name}"]).astype(float) for name in ("radius", "depth", "place")]
        return [Chamber(*map(float, size)) for size in zip(*sizes, strict=True)]
    place = run["ball_position"].transpose("time", "ball", "axis").values
    radius, number = run["ball_radius"].values, run["chamber"].values.astype(int)
    reach = np.hypot(place[:, :, 1], place[:, :, 2]).max(axis=0) + radius
    along = np.abs(place[:, :, 0]).max(axis=0) + radius
    found = []
    for chamber in range(1, int(number.max(initial=1)) + 1):
        mine = number == chamber
        found.append(Chamber(float(reach[mine].max(initial=1e-3)), 2.0 * float(along[mine].max(initial=1e-3))))
    return found

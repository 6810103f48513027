"""Ball angles of a run as a camera would give them, without its pictures."""

from __future__ import annotations

import numpy as np
import xarray as xr

SEEN = np.radians(0.2)  # standard deviation of a ball angle, rad


def seen_by_a_camera(run: xr.Dataset, random: np.random.Generator) -> xr.Dataset:
    """With white noise, whole turns not counted."""
    angle = run["ball_angle_in_rotor"]
    seen = (angle.values + SEEN * random.standard_normal(angle.shape)) % (2.0 * np.pi)
    return xr.Dataset(
        {
            "ball_angle": (("time", "ball"), seen),
            "ball_angle_deviation": (("time", "ball"), np.full(angle.shape, SEEN)),
        },
        {"time": run["time"].values, "ball": run["ball"].values},
    )

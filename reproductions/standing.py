"""A race whose balls stand still in it, as a run of which pictures are drawn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr


def standing(
    angles: Sequence[float] | np.ndarray, orbit: float, diameter: float, speed: float, turned: float = 0.0
) -> xr.Dataset:
    """One millisecond of a rotor at a speed (rad/s) with balls at rest in it at angles (rad); it is ``turned`` (rad) first."""
    time, count = np.linspace(0.0, 1e-3, 5), len(angles)
    both = ("time", "ball")
    return xr.Dataset(
        {
            "speed": ("time", np.full(time.size, speed)),
            "rotor_angle": ("time", turned + speed * time),
            "x": ("time", np.zeros(time.size)),
            "y": ("time", np.zeros(time.size)),
            "ball_angle_in_rotor": (both, np.tile(angles, (time.size, 1))),
            "ball_speed_in_rotor": (both, np.zeros((time.size, count))),
            "orbit_radius": ("ball", np.full(count, orbit)),
            "ball_diameter": ("ball", np.full(count, diameter)),
        },
        {"time": time},
    )

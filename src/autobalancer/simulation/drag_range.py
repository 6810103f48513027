"""Whether the balls of a run kept to the range in which their drag law is known."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from autobalancer.assembly.system import Assembly


def drag_range_attributes(assembly: Assembly, run: xr.Dataset) -> dict[str, Any]:
    """For the result: law, greatest Reynolds number and a warning where the law was left; empty for linear drag.

    Velocities are those saved with the run, along the race; fluid that lags is not counted.
    """
    found: dict[str, Any] = {}
    greatest: dict[Any, float] = {}
    for number, ball in enumerate(assembly.balls):
        if ball.drag_curve is None:
            continue
        for name in ("ball_speed_in_rotor", "envelope_ball_speed_in_rotor"):
            if name in run:
                speeds = np.abs(run[name].isel(ball=number).values)
                if speeds.size:
                    velocity = float(np.nanmax(speeds)) * ball.orbit_radius
                    greatest[ball.drag_curve] = max(greatest.get(ball.drag_curve, 0.0), velocity)
    for curve, velocity in greatest.items():
        record = curve.range_record(velocity)
        if not found or record["drag_reynolds"] > found["drag_reynolds"]:
            found = record
    return found

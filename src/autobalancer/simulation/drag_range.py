"""Whether the balls of a run kept to the range in which their drag law and slipstream are known."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from autobalancer.assembly.system import Assembly
from autobalancer.laws.slipstream import range_record


def drag_range_attributes(assembly: Assembly, run: xr.Dataset) -> dict[str, Any]:
    """For the result: law, greatest Reynolds number and a warning where the law was left; empty for linear drag.

    The same of the slipstream where there is one. Velocities are those saved with the run, along the race; fluid that lags is
    not counted.
    """
    found: dict[str, Any] = {}
    greatest: dict[Any, float] = {}
    in_line = -1.0
    for number, ball in enumerate(assembly.balls):
        if ball.drag_curve is None and not ball.slipstream:
            continue
        for name in ("ball_speed_in_rotor", "envelope_ball_speed_in_rotor"):
            if name in run:
                speeds = np.abs(run[name].isel(ball=number).values)
                if speeds.size:
                    velocity = float(np.nanmax(speeds)) * ball.orbit_radius
                    if ball.slipstream:
                        in_line = max(in_line, velocity * ball.diameter / ball.fluid_viscosity)
                    if ball.drag_curve is not None:
                        greatest[ball.drag_curve] = max(greatest.get(ball.drag_curve, 0.0), velocity)
    for curve, velocity in greatest.items():
        record = curve.range_record(velocity)
        if not found or record["drag_reynolds"] > found["drag_reynolds"]:
            found = record
    return found | (range_record(in_line) if in_line >= 0.0 else {})

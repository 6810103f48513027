"""Until when resolved balls lie on the floor of their annulus, in words."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from autobalancer.catalog.resolve import Ball
from autobalancer.machine import Machine
from autobalancer.results.number_text import significant
from autobalancer.results.series import lifted_from


def floor_text(machine: Machine, balls: tuple[Ball, ...], run: xr.Dataset) -> str:
    """Of all balls that a run with samples shows on a floor: until when, or from which speed on their wall would carry them."""
    if "ball_floor_force" not in run or run["time"].size == 0:
        return ""
    force = run["ball_floor_force"].values
    seconds, speeds = (lifted_from(run[name].values, force) for name in ("time", "speed"))
    told = []
    for number in np.flatnonzero(force.max(axis=0) > 0.0):
        name = f"ball {number + 1}"
        if np.isfinite(seconds[number]):
            told.append(f"{name} until {significant(seconds[number])} s ({significant(speeds[number])} rad/s)")
            continue
        ball = balls[number]
        contact = machine.balancers[ball.balancer].races[ball.race].resolved
        assert contact is not None
        sliding = float(contact.sliding_friction)
        if sliding > 0.0:
            needed = math.sqrt(float(machine.gravity) / (sliding * ball.orbit_radius))
            carried = f"friction of its wall carries it from {significant(needed)} rad/s on"
        else:
            carried = "its wall without friction never carries it"
        told.append(f"{name} up to the end; {carried}")
    return f"on the floor of the annulus: {', '.join(told)}" if told else ""

"""What friction means for the end of a run, in words."""

from __future__ import annotations

import math

import xarray as xr

from autobalancer.catalog.friction_table import NONE_GIVEN
from autobalancer.catalog.resolve import Ball
from autobalancer.laws.held_by_friction import held_whirl
from autobalancer.machine import Machine
from autobalancer.results.number_text import length_text


def friction_text(machine: Machine, balls: tuple[Ball, ...], run: xr.Dataset) -> str:
    """The whirl below which balls at rest do not move at its last speed, of all races with balls; or that there is no friction.

    Without ``balls`` the text is empty.
    """
    if not balls:
        return ""
    weight = machine.gravity / max(_last_speed(run) ** 2, 1e-300) if machine.axis == "horizontal" else 0.0
    kinds = {(ball.orbit_radius, ball.adherence) for ball in balls if ball.adherence > 0.0}
    held = [held_whirl(orbit, adherence, weight=weight) for orbit, adherence in sorted(kinds)]
    if not held:
        return NONE_GIVEN
    if max(held) < 0.0:
        return "the weight of the balls moves them in each turn at the last speed; friction does not hold them at rest"
    low, high = max(min(held), 0.0), max(held)
    span = length_text(high) if math.isclose(low, high) else f"{length_text(low)} to {length_text(high)}"
    text = f"friction holds balls at rest while their race is less than {span} off the axis of rotation"
    if not any(race.eccentricity for balancer in machine.balancers for race in balancer.races):
        return text
    return (
        text + "; an eccentric race can be farther off, and balls near the line of its whirl are held, too (see check)"
    )


def _last_speed(run: xr.Dataset) -> float:
    for name in ("turn_speed", "speed", "envelope_speed"):
        if name in run and run[name].size:
            return float(run[name].values[-1])
    return 0.0

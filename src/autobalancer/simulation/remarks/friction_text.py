"""What friction means for the end of a run, in words."""

from __future__ import annotations

import math

import xarray as xr

from autobalancer.catalog.friction_table import NONE_GIVEN
from autobalancer.laws.held_by_friction import held_whirl
from autobalancer.machine import Machine
from autobalancer.results.number_text import length_text


def friction_text(machine: Machine, orbits: dict[tuple[int, int], float], run: xr.Dataset) -> str:
    """The whirl below which balls at rest do not move at its last speed, of all races with balls; or that there is no friction.

    ``orbits`` (m) are those of the races with balls, by balancer and race; without any the text is empty.
    """
    if not orbits:
        return ""
    weight = machine.gravity / max(_last_speed(run) ** 2, 1e-300) if machine.axis == "horizontal" else 0.0
    held = []
    for (balancer, race), orbit in orbits.items():
        friction = machine.balancers[balancer].races[race].friction
        if friction is not None and friction.holding > 0.0:
            held.append(held_whirl(orbit, friction.holding, weight=weight))
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

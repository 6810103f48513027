"""Equal balls that pass through each other, made a little unequal.

Equal balls in one place obey equal equations and never part again, stable or not. Real balls are never equal: within a lot of
grade 10 (ISO 3290-1) diameters differ by up to 0.5 um, the masses of balls of 5 mm by 3e-4. A spread far below that leaves
every number of a result as it is and lets the balls leave a state that has become unstable.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from autobalancer.assembly.resolved.balls import is_resolved
from autobalancer.catalog.resolve import Ball
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.random_numbers import generator

MASS_SPREAD = 1e-6  # heaviest less lightest of equal balls over their mass, where nobody says another


def equal_groups(machine: Machine, balls: tuple[Ball, ...]) -> list[list[int]]:
    """Numbers of the balls that are equal, share a race and may lie in one place; only groups of two or more."""
    if is_resolved(machine):
        return []
    groups: dict[tuple[object, ...], list[int]] = {}
    for number, ball in enumerate(balls):
        race = machine.balancers[ball.balancer].races[ball.race]
        mates = [other for other in balls if (other.balancer, other.race) == (ball.balancer, ball.race)]
        if race.coincidence or any(other.diameter == 0.0 for other in mates):
            alike = (ball.balancer, ball.race, ball.mass, ball.diameter, ball.orbit_radius, ball.spin_ratio)
            groups.setdefault(alike, []).append(number)
    return [members for members in groups.values() if len(members) > 1]


def with_mass_spread(machine: Machine, balls: tuple[Ball, ...], spread: float, seed: int) -> tuple[Ball, ...]:
    """The balls with masses at equal steps around their mean, in an order drawn from the seed.

    Raises
    ------
    QuestionError
        For a spread below 0, or of 0.1 and more.
    """
    if not (math.isfinite(spread) and 0.0 <= spread < 0.1):
        raise QuestionError(
            f"mass_spread: given {spread:g}; must be from 0 to less than 0.1, relative to the mass of a ball"
        )
    if spread == 0.0:
        return balls
    random = generator(seed, 3290)
    changed = list(balls)
    for members in equal_groups(machine, balls):
        steps = random.permutation(np.linspace(-0.5, 0.5, len(members)))
        for number, step in zip(members, steps, strict=True):
            changed[number] = replace(balls[number], mass=balls[number].mass * (1.0 + spread * float(step)))
    return tuple(changed)

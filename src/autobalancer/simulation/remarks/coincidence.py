"""Balls that lie in one place although that state is unstable."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np

from autobalancer.assembly.mass_spread import equal_groups
from autobalancer.assembly.system import Assembly
from autobalancer.catalog.resolve import Ball, resolve
from autobalancer.kernels.system import BALLS, SPEED, THETA, Floats, Matrix, X, Y
from autobalancer.machine import Machine

TOGETHER = 1e-6  # rad; balls this near lie in one place
LATE = 0.05  # share of a run, at its end, that is looked at

CURE = (
    "Identical balls at one place never separate, real ones do: set mass_spread above 0, give the balls a size (diameter), "
    "or start them at different angles"
)


def free_groups(machine: Machine) -> list[list[int]]:
    """Numbers of equal balls, from 0, that may lie in one place and that friction does not hold there."""
    balls = resolve(machine)

    def held(number: int) -> bool:
        friction = machine.balancers[balls[number].balancer].races[balls[number].race].friction
        return friction is not None and friction.holding > 0.0

    return [members for members in equal_groups(machine, balls) if not held(members[0])]


def pairs_together(groups: list[list[int]], angles: Floats) -> list[tuple[int, int]]:
    """Those balls of each group that lie in one place, two by two."""
    return [
        (one, other)
        for members in groups
        for one, other in combinations(members, 2)
        if abs(math.remainder(float(angles[one] - angles[other]), 2.0 * math.pi)) < TOGETHER
    ]


def parting_rate(ball: Ball, speed: float, outward: float) -> float:
    """Rate at which the distance of two balls in one place grows, 1/s; not above zero if they stay together.

    The rotor does not feel it when two balls part, so their distance d obeys J d'' + beta d' + m R w^2 s d = 0 with the mean
    deflection s of the race center in the direction of the balls: balls on the side to which the rotor is deflected are held
    together, those on the other side are driven apart.

    Parameters
    ----------
    ball
        One of them.
    speed
        Of the balls in space, rad/s.
    outward
        The deflection s, m.
    """
    pull = ball.moment * speed**2 * outward
    half = 0.5 * ball.drag / ball.inertia
    return float(np.sqrt(complex(half**2 - pull / ball.inertia)).real) - half


def coincidence_text(machine: Machine, assembly: Assembly, states: Matrix) -> str:
    """A sentence if balls lie in one place in the last of the states (times, size) and are driven apart; else empty."""
    n = len(assembly.balls)
    if not n or not states.shape[0]:
        return ""
    late = states[-max(1, round(LATE * states.shape[0])) :]
    angles = late[:, BALLS : BALLS + n]
    rates = {}
    for one, other in pairs_together(free_groups(machine), angles[-1]):
        ball = assembly.balls[one]
        centers = _race_centers(assembly, ball, late)
        in_space = angles[:, one] + (0.0 if assembly.system.rotating else late[:, THETA])
        speed = float(np.mean(late[:, SPEED] + late[:, BALLS + n + one]))
        rates[one, other] = parting_rate(ball, speed, float(np.mean((centers * np.exp(-1j * in_space)).real)))
    return parting_text(rates)


def parting_text(rates: dict[tuple[int, int], float]) -> str:
    """What a result says of balls in one place that are driven apart; empty if none are."""
    driven = {pair: rate for pair, rate in rates.items() if rate > 0.0}
    if not driven:
        return ""
    one, other = max(driven, key=lambda pair: driven[pair])
    return (
        f"balls {one + 1} and {other + 1} lie in one place although this state is unstable: their distance would grow at "
        f"{driven[one, other]:.3g} 1/s. {CURE}"
    )


def _race_centers(assembly: Assembly, ball: Ball, states: Matrix) -> Floats:
    """Deflection of the race center in the frame of the integration, x + i y, (times,)."""
    z = states[:, X] + 1j * states[:, Y]
    if assembly.places.shape[0]:
        row, rest = assembly.places[ball.balancer], BALLS + 2 * len(assembly.balls)
        coordinates = np.column_stack([states[:, [X, Y]], states[:, rest : rest + row.shape[1] - 2]])
        z = coordinates @ (row[0] + 1j * row[1])
    turn = 1.0 if assembly.system.rotating else np.exp(1j * states[:, THETA])
    return np.asarray(z + ball.eccentricity * turn)

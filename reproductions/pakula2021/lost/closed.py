"""What follows from the size of the balls alone, without a run."""

from __future__ import annotations

import math

from autobalancer.laws.deep_chamber import lift
from reproductions.pakula2021.lost.candidate import DEPTH, Candidate


def row_of(candidate: Candidate, balls: int) -> int:
    """Balls that lie side by side along the axis."""
    return math.floor(DEPTH / (2.0 * candidate.ball_radius(balls)) * (1.0 + 1e-9))


def chatter(candidate: Candidate, balls: int = 5, friction: float = 0.5) -> float:
    """Greatest force along the axis with which balls in place that all slide can push the body, N."""
    radius = candidate.radius - candidate.ball_radius(balls)
    return friction * candidate.ball_mass * radius * candidate.speed**2


def filled(candidate: Candidate, balls: int) -> float:
    """Part of the race that a single layer takes, 1 if it is full and more if it does not go in."""
    share = candidate.ball_radius(balls) / (candidate.radius - candidate.ball_radius(balls))
    return balls * math.asin(share) / math.pi if 0.0 < share < 1.0 else math.inf


def single_capability(candidate: Candidate, balls: int) -> float:
    """Unbalance that a single layer can balance at most, its balls side by side, kg m."""
    radius = candidate.radius - candidate.ball_radius(balls)
    half = math.asin(min(candidate.ball_radius(balls) / radius, 1.0))
    return candidate.ball_mass / balls * radius * abs(math.sin(balls * half) / math.sin(half))


def sliding_rise(radius: float, friction: float, gravity: float = 9.80665) -> float:
    """Rate of the speed (rad/s²) above which a ball that rests in a slowly quickening drum slides.

    To spin up with the wall (radius R) a rolling ball needs the force 2/5 m R dΩ/dt. It hangs where its weight balances
    that force, tan(angle) = force/N, and friction can hold it up to tan(angle) = mu: 2/5 R dΩ/dt = g mu/sqrt(1 + mu²).
    """
    return 2.5 * gravity * friction / (radius * math.sqrt(1.0 + friction**2))


def lifted_share(friction: float, angle: float) -> float:
    """v²/(g s) of a ball that slid all the way from rest at the bottom of a fixed drum (s = R - r) up to ``angle``."""
    return 2.0 * lift(friction, angle=angle)


def lifting_friction() -> float:
    """Least friction with which a ball that slides from rest goes around in a fixed drum, whatever its size: 0.713."""
    angles = [2.0 * math.pi * (i + 1) / 4000.0 for i in range(4000)]
    low, high = 0.5, 1.0
    while high - low > 1e-6:
        middle = 0.5 * (low + high)
        goes = all((share := lifted_share(middle, angle)) > 0.0 and share + math.cos(angle) > 0.0 for angle in angles)
        low, high = (low, middle) if goes else (middle, high)
    return high

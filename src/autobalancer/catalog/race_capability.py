"""What the balls of a race can balance at most: side by side, as they really can stand; kg m."""

from __future__ import annotations

import cmath
from collections.abc import Hashable, Iterable

from autobalancer.catalog.resolve import Ball, occupied_angle


def race_capability(balls: list[Ball]) -> float:
    """Resultant of the balls of one race side by side, kg m; the best place for the gap in the row is taken.

    Of equal balls it is :func:`autobalancer.laws.ball_capability.capability`; balls of unknown size are points. It holds for
    balls that a model lets pass through each other as well.
    """
    best = 0.0
    for first in range(len(balls)):
        row = balls[first:] + balls[:first]
        angle, total = 0.0, 0j
        for ball, after in zip(row, [*row[1:], row[0]], strict=True):
            total += cmath.rect(ball.moment, angle)
            angle += 0.5 * occupied_angle([ball, after])
        best = max(best, abs(total))
    return best


def capability_of(balls: Iterable[Ball]) -> float:
    """Sum over the races, kg m: each race adds its own, in the same direction."""
    races: dict[Hashable, list[Ball]] = {}
    for ball in balls:
        races.setdefault((ball.balancer, ball.race), []).append(ball)
    return sum(race_capability(row) for row in races.values())

"""Magnetized balls that repel each other."""

from __future__ import annotations

import math
from typing import Any, ClassVar, Literal

from autobalancer.machine.balancer.force import Line, PairForce, arc
from autobalancer.machine.part import MagneticMoment, key


class RepellingBalls(PairForce):
    """Balls magnetized along the axis, each of which repels every other one of its race: dipoles side by side.

    The force between two at the distance d of their centers is 3 mu_0 M^2/(4 pi d^4) (Yung et al. 1998); outside a ball that is
    magnetized evenly its field is exactly that of a dipole, M = volume times remanence over mu_0. It spreads the balls evenly
    where nothing else moves them.
    """

    kind: Literal["repelling_balls"] = "repelling_balls"
    interface: ClassVar[int] = 1
    pairs: ClassVar[str] = "all"
    moment: MagneticMoment = key("magnetic moment of each ball, along the axis", symbol="M")

    @staticmethod
    def force(at: Any, next: Any, own: Any) -> tuple[float, float, float, float]:
        """N."""
        dx, dy = next.x - at.x, next.y - at.y
        square = max(dx * dx + dy * dy, 1e-18)
        push = 3e-7 * own.moment * own.moment / (square * square * math.sqrt(square))  # mu_0/(4 pi) is 1e-7
        return -push * dx, -push * dy, push * dx, push * dy

    @staticmethod
    def energy(at: Any, next: Any, own: Any) -> float:
        """J."""
        dx, dy = next.x - at.x, next.y - at.y
        square = max(dx * dx + dy * dy, 1e-18)
        return float(1e-7 * own.moment * own.moment / (square * math.sqrt(square)))

    def drawn(self, orbit: float, balls: list[complex], speed: float) -> list[Line]:
        """A ring around each ball."""
        return [[ball + point for point in arc(0.11 * orbit)] for ball in balls]

"""A spring from the center of the race to each ball."""

from __future__ import annotations

import math
from typing import Any, ClassVar, Literal

from autobalancer.machine.balancer.force import Force, Line, coil
from autobalancer.machine.part import Offset, SpringRate, key


class RadialSpring(Force):
    """A spring from the center of the race to each ball, as along a rod (Spannan 2021, figure 2.5 c).

    It pulls balls inward beyond its free length and pushes them outward below. Guided balls on a round race feel it in their wall
    force only; ``resolved`` ones leave the wall below w^2 = stiffness (1 - free_length/orbit) / mass.
    """

    kind: Literal["radial_spring"] = "radial_spring"
    interface: ClassVar[int] = 1
    stiffness: SpringRate = key("of each spring", symbol="k")
    free_length: Offset = key("distance of the ball center from the center of the race at which it is not loaded")

    @staticmethod
    def force(at: Any, own: Any) -> tuple[float, float]:
        """N."""
        away = math.sqrt(at.x * at.x + at.y * at.y)
        pull = -own.stiffness * (away - own.free_length) / max(away, 1e-12)
        return pull * at.x, pull * at.y

    @staticmethod
    def energy(at: Any, own: Any) -> float:
        """J."""
        stretch = math.sqrt(at.x * at.x + at.y * at.y) - own.free_length
        return float(0.5 * own.stiffness * stretch * stretch)

    def drawn(self, orbit: float, balls: list[complex], speed: float) -> list[Line]:
        """A spring to each ball."""
        return [coil(0.0, ball, 0.08 * orbit) for ball in balls]

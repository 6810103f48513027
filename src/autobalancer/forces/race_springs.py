"""Springs along the race between neighboring balls."""

from __future__ import annotations

import cmath
from typing import Any, ClassVar, Literal

from autobalancer.machine.balancer.force import Line, PairForce, bent_coil
from autobalancer.machine.part import Offset, SpringRate, key


class RaceSprings(PairForce):
    """Springs along the race, from each ball to the next around the whole ring (Spannan 2021, figure 2.5 a).

    Each is as long as the arc between the centers of its balls on the circle of the orbit radius.
    """

    kind: Literal["race_springs"] = "race_springs"
    interface: ClassVar[int] = 1
    stiffness: SpringRate = key("of each spring", symbol="k")
    free_length: Offset = key("length along the orbit at which it is not loaded", 0.0)

    @staticmethod
    def force(at: Any, next: Any, own: Any) -> tuple[float, float, float, float]:
        """N, along the tangents; the force grows with 1/radius off the orbit, so that its torque is that of the arc."""
        pull = own.stiffness * (at.orbit * next.ahead - own.free_length) * at.orbit
        one, other = pull / (at.x * at.x + at.y * at.y), pull / (next.x * next.x + next.y * next.y)
        return -one * at.y, one * at.x, other * next.y, -other * next.x

    @staticmethod
    def energy(at: Any, next: Any, own: Any) -> float:
        """J."""
        stretch = at.orbit * next.ahead - own.free_length
        return float(0.5 * own.stiffness * stretch * stretch)

    def drawn(self, orbit: float, balls: list[complex], speed: float) -> list[Line]:
        """A spring from each ball to the next."""
        angles = sorted(cmath.phase(ball) for ball in balls)
        ends = [*angles[1:], angles[0] + 2.0 * cmath.pi]
        return [
            bent_coil(orbit, one, other, 0.08 * orbit) for one, other in zip(angles, ends, strict=True) if balls[1:]
        ]

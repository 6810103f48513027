"""Pockets between pins that hold the balls until the rotor is fast enough."""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from autobalancer.machine.balancer.force import Force, Line, stroke
from autobalancer.machine.part import Angle, ForceSize, Length, Rate, key


class Pins(Force):
    """Pockets around the race that hold balls at low speed; their pins sink in as the rotor runs up (Spannan 2021, figure 2.5 e).

    Centrifugal force presses the pins against springs, so that they stand out less with the square of the speed: a pocket
    holds a ball with at most hold (1 - w^2/release_speed^2) along the race, and not at all from the release speed on. At the
    distance s from the middle of a pocket, the force back to it is that times (s/reach) e^((1 - s^2/reach^2)/2), which is
    greatest at s = reach.

    It has no energy: while the speed changes, the drive works against pins and springs.
    """

    kind: Literal["pins"] = "pins"
    interface: ClassVar[int] = 1
    count: Annotated[int, Field(ge=1)] = key("of pockets, evenly spaced")
    hold: ForceSize = key("greatest force along the race at standstill", symbol="H")
    reach: Length = key("distance from the middle of a pocket, along the orbit, at which it holds most", symbol="b")
    release_speed: Rate = key("of the rotor, at and above which the pins are in", symbol="w_r")
    angle: Angle = key("of the first pocket in the rotor", 0.0)

    @staticmethod
    def force(at: Any, own: Any) -> tuple[float, float]:
        """N, along the tangent."""
        turn = at.speed / own.release_speed
        out = 1.0 - turn * turn
        if out <= 0.0:
            return 0.0, 0.0
        pitch = 2.0 * math.pi / own.count
        angle = math.atan2(at.y, at.x) - own.angle
        angle -= pitch * math.floor(angle / pitch + 0.5)
        path = at.orbit * angle / own.reach
        back = own.hold * out * path * math.exp(0.5 * (1.0 - path * path)) / math.hypot(at.x, at.y)
        return back * at.y, -back * at.x

    def drawn(self, orbit: float, balls: list[complex], speed: float) -> list[Line]:
        """Two pins at each pocket, beside its ball; they stand out of the wall as far as at this speed."""
        half, out = max(self.reach / orbit, 0.12), max(0.0, 1.0 - (speed / self.release_speed) ** 2)
        middles = [self.angle + k * 2.0 * math.pi / self.count for k in range(self.count)]
        return [
            stroke(angle + side, (1.07 - 0.14 * out) * orbit, 1.07 * orbit)
            for angle in middles
            for side in (-half, half)
        ]

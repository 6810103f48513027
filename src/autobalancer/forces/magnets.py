"""Magnets that attract each ball, on the inner wall or elsewhere in the race."""

from __future__ import annotations

import cmath
import math
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from autobalancer.machine.balancer.force import Force, Line, arc
from autobalancer.machine.part import Angle, ForceSize, Length, key


class Magnets(Force):
    """Magnets that attract each ball, usually on the inner wall (Spannan 2021, figure 2.5 b; Cho and Jang 2017).

    The attraction is ``force_at_contact`` times e^(-gap/reach), with the gap between the ball and the pole: the force of a row
    of magnets falls like that. Without ``count`` the poles are a whole ring. ``resolved`` balls on the inner wall break away
    where the centrifugal force is greater: m r w^2 = force_at_contact, with the radius r of their center there; guided ones
    stay on their path.
    """

    kind: Literal["magnets"] = "magnets"
    interface: ClassVar[int] = 1
    force_at_contact: ForceSize = key("attraction of a ball that touches a pole", symbol="F_0")
    reach: Length = key("gap over which the attraction falls to 1/e", symbol=r"\lambda")
    radius: Length = key("of the poles, from the center of the race, such as that of the inner wall")
    count: Annotated[int, Field(ge=1)] | None = key("of single magnets, evenly spaced; without it a whole ring", None)
    angle: Angle = key("of the first single magnet in the rotor", 0.0)

    @staticmethod
    def force(at: Any, own: Any) -> tuple[float, float]:
        """N."""
        fx, fy = 0.0, 0.0
        if own.count > 0.0:
            for number in range(int(own.count)):
                angle = own.angle + number * 2.0 * math.pi / own.count
                dx, dy = own.radius * math.cos(angle) - at.x, own.radius * math.sin(angle) - at.y
                away = math.sqrt(dx * dx + dy * dy)
                pull = own.force_at_contact * math.exp((at.radius - away) / own.reach) / max(away, 1e-12)
                fx, fy = fx + pull * dx, fy + pull * dy
        else:
            away = math.sqrt(at.x * at.x + at.y * at.y)
            gap = abs(away - own.radius) - at.radius
            pull = own.force_at_contact * math.exp(-gap / own.reach) / max(away, 1e-12)
            pull = -pull if away > own.radius else pull
            fx, fy = pull * at.x, pull * at.y
        return fx, fy

    @staticmethod
    def energy(at: Any, own: Any) -> float:
        """J."""
        total = 0.0
        if own.count > 0.0:
            for number in range(int(own.count)):
                angle = own.angle + number * 2.0 * math.pi / own.count
                away = math.hypot(own.radius * math.cos(angle) - at.x, own.radius * math.sin(angle) - at.y)
                total -= own.force_at_contact * own.reach * math.exp((at.radius - away) / own.reach)
        else:
            gap = abs(math.hypot(at.x, at.y) - own.radius) - at.radius
            total = -own.force_at_contact * own.reach * math.exp(-gap / own.reach)
        return total

    def drawn(self, orbit: float, balls: list[complex], speed: float) -> list[Line]:
        """The ring of poles, or each single magnet."""
        if self.count is None:
            return [arc(0.98 * self.radius), arc(0.93 * self.radius)]
        angles = [self.angle + k * 2.0 * math.pi / self.count for k in range(self.count)]
        middles = [cmath.rect(self.radius - 0.04 * orbit, angle) for angle in angles]
        return [_box(middle, size * orbit, 0.08 * orbit) for middle in middles for size in (0.14, 0.05)]


def _box(middle: complex, width: float, height: float) -> Line:
    """A rectangle with its ``height`` along the radius."""
    out = middle / (abs(middle) or 1.0)
    corners = ((-1, -1), (-1, 1), (1, 1), (1, -1), (-1, -1))
    return [middle + 0.5 * out * complex(x * height, y * width) for x, y in corners]

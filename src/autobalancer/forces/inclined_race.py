"""A race that rises outward, so that its balls climb as the rotor runs up."""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, Literal

from autobalancer.machine.balancer.force import Force, Line, stroke
from autobalancer.machine.part import Length, Quantity, key

Incline = Annotated[float, Quantity("rad", positive=True, most=1.5)]


class InclinedRace(Force):
    """A floor that rises outward at the ``incline``, on a vertical axis (Spannan 2021, figure 2.5 d; Kellenberger 1987).

    Its weight pushes a ball inward with m g tan(incline), at every radius. It begins to climb where the centrifugal force is
    greater, w^2 = g tan(incline)/r, and then runs up to the wall, since that force grows with the radius; it comes back where
    w^2 = g tan(incline)/r of the outer radius. The balls have to be ``resolved``: guided ones stay at their orbit radius. The
    inertia of their motion along the axis is left out.
    """

    kind: Literal["inclined_race"] = "inclined_race"
    interface: ClassVar[int] = 1
    incline: Incline = key("of the floor against the plane of the race", symbol=r"\alpha")
    inner_radius: Length | None = key(
        "of the ball center where the incline begins; without it, there is no such end", None
    )
    outer_radius: Length | None = key("of the ball center where it ends; without it, there is no such end", None)

    def impossible(self, race: Any, axis: str) -> str:
        """It works by weight, on balls that can change their radius."""
        if axis != "vertical":
            return "its force is the weight along the axis, so the axis must be vertical"
        if race.resolved is None:
            return "guided balls cannot climb; make them 'resolved'"
        if self.inner_radius is not None and self.outer_radius is not None and self.inner_radius >= self.outer_radius:
            return "outer_radius: must be greater than the inner_radius"
        return ""

    @staticmethod
    def force(at: Any, own: Any) -> tuple[float, float]:
        """N."""
        away = math.hypot(at.x, at.y)
        push = -at.mass * at.gravity * math.tan(own.incline) / max(away, 1e-12)
        if away < own.inner_radius or away > own.outer_radius:  # both false where there is no such end
            push = 0.0
        return push * at.x, push * at.y

    @staticmethod
    def energy(at: Any, own: Any) -> float:
        """J."""
        away = math.hypot(at.x, at.y)
        if away < own.inner_radius:
            away = own.inner_radius
        if away > own.outer_radius:
            away = own.outer_radius
        return float(at.mass * at.gravity * math.tan(own.incline) * away)

    def drawn(self, orbit: float, balls: list[complex], speed: float) -> list[Line]:
        """Strokes down the incline."""
        begin, end = self.inner_radius or 0.8 * orbit, self.outer_radius or 0.97 * orbit
        return [stroke(k * math.pi / 18.0, begin, end) for k in range(36)]

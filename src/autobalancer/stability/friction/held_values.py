"""What friction holds in a plane, as values that say themselves in words."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from autobalancer.results.number_text import length_text, moment_text

RELEASED = "released at rest at this speed at random places (not a run-up)"


@dataclass(frozen=True)
class HeldPlane:
    """What friction does to the balls of one plane at one speed; SI.

    ``held_whirl``: distance of the race from the axis of rotation below which no ball at rest moves, at any angle.
    ``unbalance_whirl``: what the unbalance makes there while the balls are spread evenly, and ``largest_whirl`` the greatest
    at a critical speed on the way up. ``held_residual``: residual
    unbalance that makes the held whirl; the balls may rest at any smaller one. ``worst_residual``: the largest at which
    they can stop on their way to balance. ``median_residual`` and ``residual_95``: half, and 95 %, of the balls released at
    rest at this constant speed at random places end below; ``trapped_share`` of them end above the worst one, with balls in
    line that balance next to nothing.
    ``rest_interval``: to each side of its balanced place a ball stays within it while the others stand right.
    ``heavy_interval``: balls that stand within it about the heavy place all stay there, and add to the unbalance. Angles in rad.
    ``greatest_acceleration``: of the rotor, rad/s^2, up to which adherence alone takes a ball along that rests.
    ``drive_acceleration``: the greatest that the drive prescribes above this speed, rad/s^2, reduced by the square of the
    speed where it is higher, because friction holds more there; None if the speed follows from a torque.
    """

    name: str
    adherence: float
    rolling_resistance: float
    held_whirl: float
    unbalance_whirl: float
    largest_whirl: float
    required: float
    capability: float
    held_residual: float
    worst_residual: float
    median_residual: float
    residual_95: float
    trapped_share: float
    median_whirl: float
    whirl_95: float
    rest_interval: float
    heavy_interval: float
    greatest_acceleration: float
    drive_acceleration: float | None = None

    @property
    def holds(self) -> bool:
        """Whether evenly spread balls at rest do not move under the unbalance."""
        return self.unbalance_whirl <= self.held_whirl

    @property
    def sentence(self) -> str:
        """All that in words."""
        if self.held_whirl <= 0.0:
            return "the weight of the balls moves them in each turn; friction does not hold them at rest"
        first = (
            f"balls at rest stay put below a whirl of {length_text(self.held_whirl)}; the unbalance of "
            f"{moment_text(self.required)} alone makes {length_text(self.unbalance_whirl)}"
        )
        residual = f"residual up to {moment_text(self.worst_residual)}"
        often = f"{RELEASED}: median {moment_text(self.median_residual)}, 95 % below {moment_text(self.residual_95)}"
        if self.trapped_share > 0.0:
            ended = "trapped in line" if self.trapped_share < 0.5 else "without any balance"
            often += f", {100.0 * self.trapped_share:.2g} % {ended}"
        if self.holds:
            before = (
                f"; on the way up the whirl of {length_text(self.largest_whirl)} at a critical speed may have moved them"
                if self.largest_whirl > self.held_whirl
                else "; nor does any whirl on the way up"
            )
            return f"{first}: THE BALLS WILL NOT MOVE at this speed{before}; {residual}, unbalance and balls together; {often}"
        return (
            f"{first}; {residual}; {often}; each ball rests within {_deg(self.rest_interval)} of its balanced place, and "
            f"balls within {_deg(self.heavy_interval)} of the heavy place stay there"
        )

    @property
    def settled_sentence(self) -> str:
        """What is left if the balls settle at this speed, and the speed then rises without moving them."""
        return (
            f"balls that settle there: residual up to {moment_text(self.worst_residual)}; {RELEASED}: median "
            f"{moment_text(self.median_residual)}, 95 % below {moment_text(self.residual_95)}; they stay while the speed "
            f"then rises by less than {self.greatest_acceleration:.2g} rad/s^2{self._drive}"
        )

    @property
    def carried_on(self) -> bool | None:
        """Whether the drive rises too fast for resting balls to stay; None where it does not prescribe the speed."""
        return None if self.drive_acceleration is None else self.drive_acceleration >= self.greatest_acceleration

    @property
    def _drive(self) -> str:
        if not self.drive_acceleration:  # a torque, or no rise at all
            return ""
        if self.carried_on:
            return f"; the drive rises by {self.drive_acceleration:.3g} rad/s^2 and carries them on"
        return "; the drive rises more slowly"


@dataclass(frozen=True)
class HeldByFriction:
    """What friction holds in each plane with balls at a speed (rad/s), with ``starts`` random starts; and a note.

    Without friction ``planes`` is empty and the note says so.
    """

    speed: float
    starts: int
    planes: tuple[HeldPlane, ...]
    note: str

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers and texts, e.g. for JSON."""
        planes = [
            {**asdict(plane), "holds": plane.holds, "carried_on": plane.carried_on, "sentence": plane.sentence}
            for plane in self.planes
        ]
        return {**asdict(self), "planes": planes}


def _deg(angle: float) -> str:
    return f"{math.degrees(angle):.2g} deg"

"""What friction holds in a plane, as values that say themselves in words."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from autobalancer.results.number_text import length_text, moment_text
from autobalancer.shown import facts_text, rpm_and_si

RELEASED = "released at rest at this speed at random places (not a run-up)"


@dataclass(frozen=True)
class HeldPlane:
    """What friction does to the balls of one plane at one speed; SI.

    ``held_whirl``: distance of the race from the axis of rotation below which no ball at rest moves, at any angle.
    ``unbalance_whirl``: what the unbalance, and the eccentricity of the race, make there while the balls are spread evenly,
    and ``largest_whirl`` the greatest at a critical speed on the way up. ``held_residual``: residual unbalance that makes the
    held whirl; the balls may rest at any smaller one. ``worst_residual``: the largest at which they can stop on their way to
    balance, with ``eccentric_residual``, which a race off the axis leaves without friction, too. ``median_residual`` and
    ``residual_95``: half, and 95 %, of the balls released at rest at this constant speed at random places end below,
    ``greatest_residual`` all of them; ``trapped_share`` of them are held farther from balance than the worst, with balls in
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
    eccentric_residual: float
    greatest_residual: float
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
    def rows(self) -> tuple[tuple[str, str], ...]:
        """All that in words: labels, the first of them empty, and texts."""
        if self.held_whirl <= 0.0:
            return (("", "the weight of the balls moves them in each turn; friction does not hold them at rest"),)
        off = self.eccentric_residual > 0.0
        first = (
            f"balls at rest do not move unless the race whirls by more than {length_text(self.held_whirl)}; "
            f"the unbalance of {moment_text(self.required)} {'and the eccentricity' if off else 'alone'} "
            f"{'make' if off else 'makes'} {length_text(self.unbalance_whirl)}"
        )
        found = [("", first), ("residual", self._worst), ("starts", self._starts)]
        if self.trapped_share > 0.0:
            ended = "trapped in line" if self.trapped_share < 0.5 else "without any balance"
            share = f"{100.0 * self.trapped_share:.2g} % of them end {ended}"
            found.append(("trapped", f"{share}, with up to {moment_text(self.greatest_residual)}"))
        if not self.holds:
            near = f"each ball rests within {_deg(self.rest_interval)} of its balanced place"
            return *found, (
                "places",
                f"{near}, and balls within {_deg(self.heavy_interval)} of the heavy place stay there",
            )
        before = (
            f"on the way up the whirl of {length_text(self.largest_whirl)} at a critical speed may have moved them"
            if self.largest_whirl > self.held_whirl
            else "nor does any whirl on the way up"
        )
        return found[0], ("moving", f"THE BALLS WILL NOT MOVE at this speed; {before}"), *found[1:]

    @property
    def settled_rows(self) -> tuple[tuple[str, str], ...]:
        """What is left if the balls settle at this speed, and the speed then rises without moving them."""
        rise = f"they keep these places only if the speed rises slower than {self.greatest_acceleration:.2g} rad/s^2{self._drive}"
        return ("", f"balls that settle there: {self._worst}"), ("starts", self._starts), ("rise", rise)

    @property
    def sentence(self) -> str:
        """The rows as one text."""
        return "; ".join(text for _, text in self.rows)

    @property
    def settled_sentence(self) -> str:
        """The rows of balls that settle as one text."""
        return "; ".join(text for _, text in self.settled_rows)

    @property
    def _worst(self) -> str:
        worst = moment_text(self.worst_residual)
        if self.holds:
            return f"at most {worst}, unbalance and balls together"
        where = f"at worst {worst}, if the balls stick before they reach balance"
        if self.eccentric_residual > 0.0:
            where += f"; {moment_text(self.eccentric_residual)} of it is left by the eccentric race, and friction holds the rest"
        return where

    @property
    def _starts(self) -> str:
        return f"{RELEASED}: median {moment_text(self.median_residual)}, 95 % below {moment_text(self.residual_95)}"

    @property
    def carried_on(self) -> bool | None:
        """Whether the drive rises too fast for resting balls to stay; None where it does not prescribe the speed."""
        return None if self.drive_acceleration is None else self.drive_acceleration >= self.greatest_acceleration

    @property
    def _drive(self) -> str:
        if not self.drive_acceleration:  # a torque, or no rise at all
            return ""
        if self.carried_on:
            return f"; this drive ({self.drive_acceleration:.3g} rad/s^2) moves them again"
        return "; this drive rises more slowly"


@dataclass(frozen=True)
class HeldByFriction:
    """What friction holds in each plane with balls at a speed (rad/s), with ``starts`` random starts; and a note.

    Without friction ``planes`` is empty and the note says so.
    """

    speed: float
    starts: int
    planes: tuple[HeldPlane, ...]
    note: str

    def __repr__(self) -> str:
        rows = [
            (plane.name if not k else label, text)
            for plane in self.planes
            for k, (label, text) in enumerate(plane.rows)
        ]
        told = [facts_text(rows)] if rows else []
        return "\n".join((f"friction at {rpm_and_si(self.speed)}", *told, *([self.note] if self.note else [])))

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers and texts, e.g. for JSON."""
        planes = [
            {**asdict(plane), "holds": plane.holds, "carried_on": plane.carried_on, "sentence": plane.sentence}
            for plane in self.planes
        ]
        return {**asdict(self), "planes": planes}


def _deg(angle: float) -> str:
    return f"{math.degrees(angle):.2g} deg"

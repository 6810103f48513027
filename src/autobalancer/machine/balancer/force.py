"""Forces on the balls of a race that come from neither contact nor fluid: springs, magnets, pins, ... and yours."""

from __future__ import annotations

from typing import Any, ClassVar

from autobalancer.machine.balancer.shapes import Line
from autobalancer.machine.leaves import Leaf


class Force(Leaf):
    """A force on each ball of a race by itself.

    A leaf of this family is one class with these static methods, which are compiled when they are first used; ``at`` is the place
    of the ball (fields of ``PLACE`` in kernels/records/forces.py), ``own`` has the keys of the leaf that are numbers.

    ``force(at, own) -> (fx, fy)``
        Force on the ball in N, in the axes of its race, which turn with the rotor.
    ``energy(at, own) -> float``
        Its potential energy in J; only a conservative force has one, and that is checked.

    What the ball gets the race gives: the opposite force acts on it at the place of the ball.
    """

    family: ClassVar[str] = "forces"
    one: ClassVar[str] = "force"
    current: ClassVar[int] = 1
    pairs: ClassVar[str] = ""  # of a PairForce: "neighbors" or "all"

    @classmethod
    def conservative(cls) -> bool:
        """Whether it says so itself, by having an energy."""
        return hasattr(cls, "energy")

    def impossible(self, race: Any, axis: str) -> str:
        """Why it cannot act in this race of a machine with this axis (``"vertical"`` or ``"horizontal"``); empty if it can."""
        return ""

    def drawn(self, orbit: float, balls: list[complex], speed: float) -> list[Line]:
        """Lines for pictures of a race with this orbit radius and balls at these places, m, at this speed of the rotor, rad/s."""
        return []


class PairForce(Force):
    """A force between two balls of a race.

    With ``pairs = "neighbors"`` it acts between each ball and the next of its race around the whole ring, with ``"all"`` between
    every two balls, once. ``next.ahead`` is the angle by which the next ball is ahead.

    ``force(at, next, own) -> (fx, fy, fx_next, fy_next)``
        Forces on both; what they do not cancel the race carries.
    ``energy(at, next, own) -> float``
        Potential energy of both in J; only a conservative force has one, and that is checked.
    """

    pairs: ClassVar[str] = "neighbors"

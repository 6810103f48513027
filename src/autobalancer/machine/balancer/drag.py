"""How the fluid brakes a ball that moves in its race: what a drag law is.

In the Stokes range the product of drag coefficient and Reynolds number is a constant of the geometry, and the drag is linear,
T = beta phi' with beta = (c_d Re) (pi/4) rho nu r_b eps^2 (Spannan 2021, 5.26). A law of ``range`` "linear" keeps to that at
any speed; one of range "whole" follows c_d(Re).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Literal, NamedTuple

from autobalancer.machine.leaves import Leaf

if TYPE_CHECKING:
    from autobalancer.laws.drag_coefficient import DragLaw

Range = Literal["linear", "whole"]

RANGE = "`linear` at any speed, or `whole`: over all Reynolds numbers"


class BallInRace(NamedTuple):
    """What a drag law knows of a ball: its ``radius`` and the ``orbit_radius`` of its center, m."""

    radius: float
    orbit_radius: float


class Drag(Leaf):
    """How the fluid brakes a ball: its drag coefficient over the Reynolds number of its diameter.

    A law of this family is one class with the key ``law`` and the method ``curve``.
    """

    family: ClassVar[str] = "drag"
    one: ClassVar[str] = "drag law"
    tag: ClassVar[str] = "law"
    current: ClassVar[int] = 1
    needs_fluid: ClassVar[bool] = True

    def curve(self, ball: BallInRace) -> DragLaw:
        """Drag coefficient of this ball; your own is made by ``ab.laws.sampled_drag_law`` or ``linear_drag_law``."""
        raise NotImplementedError(f"{type(self).__name__} has no method 'curve'")

    def torque(self, ball: BallInRace) -> float:
        """Torque over speed in the rotor, N m s, of a law that needs no fluid; such a law has no curve."""
        raise NotImplementedError(f"{type(self).__name__} needs no fluid, but has no method 'torque'")

    @classmethod
    def listed(cls) -> tuple[DragLaw, ...]:
        """What lists and pictures of drag laws show of it."""
        return ()

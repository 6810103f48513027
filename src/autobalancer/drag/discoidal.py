"""The race of the discoidal rig."""

from __future__ import annotations

from typing import ClassVar, Literal

from autobalancer.laws.drag_coefficient import CubicLaw, DragLaw, joined, linear_drag_law
from autobalancer.machine.balancer.fluid import RANGE, BallInRace, Drag, Range
from autobalancer.machine.part import Positive, key

STOKES_CD_RE = 387.0


class DiscoidalDrag(Drag):
    """The race of the discoidal rig (Spannan 2021, 6.9), repaired; ``plateau`` is 0.60 as stated, or 0.74 as in the fit."""

    law: Literal["discoidal"] = "discoidal"
    interface: ClassVar[int] = 1
    plateau: Positive = key("drag coefficient from Re = 20 000 on: 0.60 as stated, 0.74 as in the printed fit", 0.60)
    range: Range = key(RANGE, "whole")

    def curve(self, ball: BallInRace) -> DragLaw:
        """See :func:`discoidal`."""
        return discoidal(float(self.plateau)) if self.range == "whole" else linear_drag_law(STOKES_CD_RE)

    @classmethod
    def listed(cls) -> tuple[DragLaw, ...]:
        """With both plateaus of the source."""
        return discoidal(), discoidal(0.74)


def discoidal(plateau: float = 0.60) -> CubicLaw:
    """The race of the discoidal rig (Spannan 2021, 6.9), repaired: 387/Re up to 10, the stated plateau from 20 000 on.

    The printed cubic gives c_d = 403 where it should give 0.6: its last coefficient is 0.0038, not 0.038, and belongs to a
    plateau of 0.74. With this plateau the repaired law rounds to the printed coefficients.
    """
    source = f"Spannan (2021), (6.9), refitted to the plateau {plateau:g}"
    return joined(STOKES_CD_RE, plateau, "discoidal", source)

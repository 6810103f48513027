"""A ball in the annulus of a balancer."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import model_validator

from autobalancer.laws.drag_coefficient import (
    PLANE_PLATEAU,
    CubicLaw,
    DragLaw,
    annulus_cd_times_re,
    joined,
    linear_drag_law,
)
from autobalancer.machine.balancer.fluid import RANGE, BallInRace, Drag, Range
from autobalancer.machine.part import Length, Positive, key


class AnnulusDrag(Drag):
    """A ball in the annulus of a balancer; ``clear_width`` is W_1 of Spannan 2021, (5.22).

    Over the whole range c_d tends to ``plateau`` at Re = 20 000, by default that of a sphere on a plane, 0.74.
    """

    law: Literal["race_geometry"] = "race_geometry"
    interface: ClassVar[int] = 1
    clear_width: Length = key("$W_1$ of Spannan (2021), figure 5.7", symbol="W_1")
    range: Range = key(RANGE, "linear")
    plateau: Positive | None = key("drag coefficient from Re = 20 000 on; without it 0.74", None)

    @model_validator(mode="after")
    def _sense(self) -> AnnulusDrag:
        if self.range == "linear" and self.plateau is not None:
            raise ValueError("plateau: has no effect on a linear law; leave it out, or set range = 'whole'")
        return self

    def curve(self, ball: BallInRace) -> DragLaw:
        """(5.22) for this ball, see :func:`race_geometry`."""
        cd_times_re = annulus_cd_times_re(float(self.clear_width) / ball.radius, ball.radius / ball.orbit_radius)
        plateau = PLANE_PLATEAU if self.plateau is None else float(self.plateau)
        return race_geometry(cd_times_re, plateau) if self.range == "whole" else linear_drag_law(cd_times_re)


def race_geometry(cd_times_re: float, plateau: float = PLANE_PLATEAU) -> CubicLaw:
    """``cd_times_re`` of :func:`annulus_cd_times_re` (Spannan 2021, 5.22) up to Re = 10; beyond, where nothing was measured,
    joined to the ``plateau`` of a sphere on a plane (5.21)."""
    source = f"Spannan (2021), (5.22), beyond Re = 10 assumed: joined to the plateau {plateau:g}"
    return joined(cd_times_re, plateau, "race_geometry", source)

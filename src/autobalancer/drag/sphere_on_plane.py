"""A sphere that rolls on a plane."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from autobalancer.laws.drag_coefficient import CRISIS, PLANE_PLATEAU, CubicLaw, DragLaw, linear_drag_law
from autobalancer.machine.balancer.fluid import RANGE, BallInRace, Drag, Range
from autobalancer.machine.part import key

STOKES_CD_RE = 322.0


class PlaneDrag(Drag):
    """A ball that rolls on a plane wall: c_d Re = 322 up to Re = 10 (Jan and Chen 1997; Spannan 2021, 5.21)."""

    law: Literal["sphere_on_plane"] = "sphere_on_plane"
    interface: ClassVar[int] = 1
    range: Range = key(RANGE, "linear")

    def curve(self, ball: BallInRace) -> DragLaw:
        """See :func:`sphere_on_plane`."""
        return sphere_on_plane() if self.range == "whole" else linear_drag_law(STOKES_CD_RE)

    @classmethod
    def listed(cls) -> tuple[DragLaw, ...]:
        """The law itself."""
        return (sphere_on_plane(),)


def sphere_on_plane() -> CubicLaw:
    """A sphere that rolls on a plane (Jan and Chen 1997; Spannan 2021, 5.21).

    As printed it jumps by 0.03 % at Re = 10 and by 0.18 % at 20 000. A straight line in log10 Re, added to the printed
    exponent, closes both; nowhere does it change c_d by more than these.
    """
    printed, ends = np.array([3.02, -1.89, 0.411, -0.033]), np.log10([10.0, 2e4])
    gaps = np.log10([STOKES_CD_RE / 10.0, PLANE_PLATEAU]) - np.polynomial.polynomial.polyval(ends, printed)
    tilt = (gaps[1] - gaps[0]) / (ends[1] - ends[0])
    printed[:2] += gaps[0] - tilt * ends[0], tilt
    source = "Jan and Chen (1997), Spannan (2021), (5.21), jumps at Re = 10 and 20 000 closed"
    return CubicLaw("sphere_on_plane", source, STOKES_CD_RE, 10.0, 2e4, CRISIS, tuple(printed.tolist()))

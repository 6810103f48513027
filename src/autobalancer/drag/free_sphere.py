"""A ball far from walls."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np

from autobalancer.arrays import Floats
from autobalancer.laws.drag_coefficient import CRISIS, DragLaw, linear_drag_law
from autobalancer.machine.balancer.fluid import RANGE, BallInRace, Drag, Range
from autobalancer.machine.part import key

STOKES_CD_RE = 24.0


class FreeSphereDrag(Drag):
    """A ball far from walls: 24/Re, then Cheng (2009) up to Re = 2e5."""

    law: Literal["free_sphere"] = "free_sphere"
    interface: ClassVar[int] = 1
    range: Range = key(RANGE, "whole")

    def curve(self, ball: BallInRace) -> DragLaw:
        """See :func:`free_sphere`."""
        return free_sphere() if self.range == "whole" else linear_drag_law(STOKES_CD_RE)

    @classmethod
    def listed(cls) -> tuple[DragLaw, ...]:
        """The law itself."""
        return (free_sphere(),)


@dataclass(frozen=True)
class SphereLaw(DragLaw):
    """A free sphere after Cheng (2009), less what his law has above Stokes' at ``stokes_end``."""

    def _log_product(self, log_re: Floats) -> Floats:
        return np.asarray(np.log(self._value(np.exp(log_re))))

    def _product_slope(self, log_re: Floats) -> Floats:
        re = np.exp(log_re)
        faded = np.exp(-0.04 * re**0.38)
        growth = 24.0 * 0.43 * 0.27 * (1.0 + 0.27 * re) ** -0.57
        growth += 0.47 * (1.0 - faded + 0.04 * 0.38 * re**0.38 * faded)
        return np.asarray(re * growth / self._value(re))

    def _value(self, re: Any) -> Any:
        return self.cd_times_re + _cheng(re) - _cheng(self.stokes_end)


def free_sphere() -> SphereLaw:
    """A sphere far from walls: Stokes' 24/Re, then Cheng (2009), made for Re < 2e5.

    Below Re = 0.001 the drag is exactly linear; so that nothing jumps there, c_d Re is 0.0028 less than his everywhere.
    """
    return SphereLaw("free_sphere", "Stokes; Cheng (2009)", STOKES_CD_RE, 1e-3, CRISIS, CRISIS)


def _cheng(re: Any) -> Any:
    return 24.0 * (1.0 + 0.27 * re) ** 0.43 + 0.47 * re * (1.0 - np.exp(-0.04 * re**0.38))

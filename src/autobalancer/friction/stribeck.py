"""More friction at the onset of sliding."""

from __future__ import annotations

import math
from typing import Any, ClassVar, Literal

from autobalancer.machine.balancer.resolved import FrictionLaw, SlipSpeed
from autobalancer.machine.part import Ratio, key


class Stribeck(FrictionLaw):
    """A greater coefficient ``peak`` at the onset of sliding, which fades over ``peak_speed`` (Spannan 2021, 5.7).

    (5.7) as printed has the factor 1.0 - mu_kin, by which any contact would start to slide at about mu = 1 whatever its peak; it
    is mu_adh - mu_kin here.
    """

    kind: Literal["stribeck"] = "stribeck"
    interface: ClassVar[int] = 1
    peak: Ratio = key("coefficient at the onset of sliding", symbol=r"\mu_\mathrm{peak}")
    peak_speed: SlipSpeed = key("slip speed over which it decreases to `sliding_friction`")

    def unfit(self, sliding: float) -> str:
        """The peak is the greatest value."""
        if self.peak >= sliding:
            return ""
        return f"peak: given {self.peak:g}; must not be less than the sliding friction, {sliding:g}"

    @staticmethod
    def coefficient(at: Any, own: Any) -> float:
        """Odd in the slip."""
        level = at.sliding + (own.peak - at.sliding) * math.exp(-abs(at.slip) / own.peak_speed)
        return level * math.tanh(at.slip / at.slip_speed)  # type: ignore[no-any-return]

"""Drag of a known product of drag coefficient and Reynolds number."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import model_validator

from autobalancer.laws.drag_coefficient import DragLaw, joined, linear_drag_law
from autobalancer.machine.balancer.fluid import RANGE, BallInRace, Drag, Range
from autobalancer.machine.part import Positive, key


class CoefficientDrag(Drag):
    """A known product of drag coefficient and Reynolds number; over the whole range also the ``plateau`` of c_d."""

    law: Literal["cd_times_re"] = "cd_times_re"
    interface: ClassVar[int] = 1
    cd_times_re: Positive = key("drag coefficient times Reynolds number", symbol=r"c_d \mathrm{Re}")
    range: Range = key(RANGE, "linear")
    plateau: Positive | None = key("drag coefficient from Re = 20 000 on; required by `whole`", None)

    @model_validator(mode="after")
    def _sense(self) -> CoefficientDrag:
        if self.range == "linear" and self.plateau is not None:
            raise ValueError("plateau: has no effect on a linear law; leave it out, or set range = 'whole'")
        if self.range == "whole" and self.plateau is None:
            raise ValueError(
                "plateau: missing; over the whole range give the drag coefficient at high Reynolds numbers"
            )
        return self

    def curve(self, ball: BallInRace) -> DragLaw:
        """The constant, joined to the plateau over the whole range."""
        cd_times_re = float(self.cd_times_re)
        return (
            joined(cd_times_re, float(self.plateau or 0.0)) if self.range == "whole" else linear_drag_law(cd_times_re)
        )

"""Measured drag coefficients."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from autobalancer.laws.drag_coefficient import DragLaw, table
from autobalancer.machine.balancer.fluid import BallInRace, Drag
from autobalancer.machine.part import Listed, Positive, key


class TableDrag(Drag):
    """Measured drag coefficients over increasing Reynolds numbers; linear below the first, c_d kept beyond the last."""

    law: Literal["table"] = "table"
    interface: ClassVar[int] = 1
    reynolds: Annotated[tuple[Positive, ...], Listed] = key(
        "must increase; drag is linear below the first, its coefficient is constant above the last"
    )
    coefficient: Annotated[tuple[Positive, ...], Listed] = key(
        "as many as Reynolds numbers; coefficient times Reynolds number must not fall"
    )

    def curve(self, ball: BallInRace) -> DragLaw:
        """See :func:`autobalancer.laws.drag_coefficient.table`."""
        return table(self.reynolds, self.coefficient)

"""Coulomb's friction, made smooth."""

from __future__ import annotations

import math
from typing import Any, ClassVar, Literal

from autobalancer.machine.balancer.resolved import FrictionLaw


class Coulomb(FrictionLaw):
    """The same coefficient at any slip much faster than ``slip_speed`` (Spannan 2021, 5.6)."""

    kind: Literal["coulomb"] = "coulomb"
    interface: ClassVar[int] = 1

    @staticmethod
    def coefficient(at: Any, own: Any) -> float:
        """Odd in the slip."""
        return at.sliding * math.tanh(at.slip / at.slip_speed)  # type: ignore[no-any-return]

"""Measured stiffness and loss of rubber."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autobalancer.laws.rubber import Motion

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class RubberPoints:
    """Complex stiffness K' + i K'' of rubber at n points, SI; arrays of shape (n,).

    ``frequency`` rad/s, ``amplitude`` m, ``stiffness`` K' and ``loss`` K'' N/m (nan where it was not measured), their standard
    uncertainties, N/m; ``motion`` circle or line, ``kind`` loop or resonance, ``names`` for messages.
    """

    frequency: Floats
    amplitude: Floats
    stiffness: Floats
    loss: Floats
    stiffness_uncertainty: Floats
    loss_uncertainty: Floats
    motion: tuple[Motion, ...]
    kind: tuple[str, ...]
    names: tuple[str, ...]

    def __len__(self) -> int:
        return self.frequency.size


def joined(parts: list[RubberPoints]) -> RubberPoints:
    """All points in one."""

    def array(name: str) -> Floats:
        return np.concatenate([getattr(part, name) for part in parts])

    return RubberPoints(
        array("frequency"),
        array("amplitude"),
        array("stiffness"),
        array("loss"),
        array("stiffness_uncertainty"),
        array("loss_uncertainty"),
        tuple(one for part in parts for one in part.motion),
        tuple(one for part in parts for one in part.kind),
        tuple(one for part in parts for one in part.names),
    )

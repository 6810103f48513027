"""What is known of a special point of a curve."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from autobalancer.stability.continuation.follow import Point
from autobalancer.stability.continuation.steady import Steady
from autobalancer.stability.continuation.symmetry import Groups
from autobalancer.stability.host.planar import Complexes, Floats


@dataclass(frozen=True)
class Special:
    """A special point, and where to go on from it."""

    kind: str  # fold, Hopf, pitchfork, branch point
    point: Point
    frequency: float = math.nan  # of the Hopf mode, rad/s
    lyapunov: float = math.nan  # first Lyapunov coefficient for an amplitude of the ball angle in rad
    mode: Complexes = field(default_factory=lambda: np.zeros(0, np.complex128))  # scaled, ball angle of amplitude 1 rad
    onward: tuple[tuple[Groups, Floats], ...] = ()  # groups and direction of the ball groups of what branches off
    ends: bool = False  # beyond it the curve is its own copy with balls exchanged


def crossing_at(problem: Steady, point: Point, ends: bool) -> Special:
    """A branch point without a symmetry of its own: on along the other direction in the kernel."""
    vectors = np.linalg.svd(problem.bordered(point.u, point.tangent)[:-1])[2][-2:]
    t = point.tangent / np.linalg.norm(point.tangent)
    other = max((v - (v @ t) * t for v in vectors), key=lambda v: float(np.linalg.norm(v)))
    return Special("branch point", point, onward=((problem.groups, other / np.linalg.norm(other)),), ends=ends)

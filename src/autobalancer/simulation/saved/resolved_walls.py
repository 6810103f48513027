"""Where contact-resolved balls are between their walls, and how these press them, at saved states."""

from __future__ import annotations

from typing import Any

import numpy as np

from autobalancer.kernels.system import Matrix, System


def wall_contacts(own: Any, system: System) -> tuple[Matrix, Matrix]:
    """Distance from the outer wall (m, negative in contact) and its normal force (N) on each ball; (times, n) each.

    ``own`` are the states of the balls, (times, n, BALL_STATES).
    """
    from autobalancer.kernels.balls.wall_contacts import contacts

    states = np.ascontiguousarray(own, np.float64)
    gap, force = np.zeros(states.shape[:2]), np.zeros(states.shape[:2])
    contacts(states, system, gap, force)
    return gap, force


def wall_forces(own: Any, system: System) -> Matrix:
    """The normal force alone."""
    return wall_contacts(own, system)[1]

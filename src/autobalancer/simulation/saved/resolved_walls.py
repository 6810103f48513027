"""Where contact-resolved balls are between their walls, and how walls and floor press them, at saved states."""

from __future__ import annotations

from typing import Any

import numpy as np

from autobalancer.kernels.system import Matrix, System


def wall_contacts(own: Any, system: System) -> tuple[Matrix, Matrix, Matrix]:
    """Distance from the outer wall (m, negative in contact), its normal force and that of the floor (N) on each ball; (times, n).

    ``own`` are the states of the balls, (times, n, BALL_STATES).
    """
    from autobalancer.kernels.balls.wall_contacts import contacts

    states = np.ascontiguousarray(own, np.float64)
    gap, force, floor = (np.zeros(states.shape[:2]) for _ in range(3))
    contacts(states, system, gap, force, floor)
    return gap, force, floor


def wall_forces(own: Any, system: System) -> Matrix:
    """The normal force of the outer wall alone."""
    return wall_contacts(own, system)[1]

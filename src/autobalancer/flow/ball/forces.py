"""Force and torque of the fluid on a ball, from the forces that hold its nodes."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from autobalancer.flow.ball.slow import Flow


class BallForces(NamedTuple):
    """On a whole ball: ``along`` the race against its motion and ``lift`` away from the outer wall over mu r U, ``torque``
    against rolling over mu r^2 U."""

    along: float
    lift: float
    torque: float

    def drag(self, share: float = 1.0) -> float:
        """What has to push a ball that turns with a ``share`` of rolling: force and torque over the radius work together."""
        return self.along + share * self.torque


def ball_forces(flow: Flow, ball: int = 0) -> BallForces:
    """Of the ball with this number, 0 for the one at the origin.

    The equations use mu grad u for the stress; its transpose adds no force, and to a sphere that turns relative to the walls
    with s the torque -8 pi/3 s.
    """
    spaces = flow.spaces
    on, (x, y) = spaces.on_ball(ball), spaces.shape.centers()[ball]
    force = -2.0 * flow.residual[:, on]
    arm = spaces.nodes[:2, on] - np.array([[x], [y]])
    turning = flow.spin - spaces.shape.turning
    added = 0.0 if flow.whole_stress else -8.0 * math.pi / 3.0 * turning
    torque = float(np.sum(arm[0] * force[1] - arm[1] * force[0])) + added
    # the second ball stands at another angle of the race
    tangent = np.array([1.0, 0.0]) if math.isinf(spaces.shape.orbit) else _tangent(x, y, spaces.shape.orbit)
    along, inward = tangent @ force[:2].sum(axis=1), np.array([-tangent[1], tangent[0]]) @ force[:2].sum(axis=1)
    return BallForces(-float(along), float(inward), torque)


def _tangent(x: float, y: float, orbit: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return np.array([orbit - y, x]) / orbit

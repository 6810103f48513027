"""Velocities in the plane of the ball centers on a regular grid, for pictures."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from autobalancer.flow.ball.mesh import Floats
from autobalancer.flow.ball.slow import Flow

REACH = 4.0  # ball radii to both sides
STEP = 0.04


def plane(flow: Flow) -> tuple[Floats, Floats, Floats]:
    """x, y and the velocity relative to the ball, (2, x, y), in ball radii and its speed; nan in balls and walls."""
    spaces = flow.spaces
    shape, nodes = spaces.shape, spaces.nodes
    on = np.abs(nodes[2]) < 1e-9
    low, high = max(-shape.behind, -REACH), min(shape.ahead, REACH + np.nan_to_num(shape.second))
    bottom, top = nodes[1, on & (nodes[0] > low) & (nodes[0] < high)].min(), shape.width - 1.0 - shape.gap
    x, y = np.arange(low, high + STEP, STEP), np.append(np.arange(bottom, top, STEP), top)
    grid = np.meshgrid(x, y, indexing="ij")
    velocity = (flow.deviation + spaces.walls_velocity())[:2, on]
    found = np.moveaxis(LinearNDInterpolator(nodes[:2, on].T, velocity.T)(*grid), -1, 0)
    depth = shape.depth(*grid)
    outside = (depth < 0.0) | (depth > shape.width)
    for a, b in shape.centers():
        outside |= np.hypot(grid[0] - a, grid[1] - b) < 1.0
    found[:, outside] = np.nan
    return x, y, found

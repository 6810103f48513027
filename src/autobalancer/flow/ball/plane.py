"""Velocities in the plane of the ball centers on a regular grid, for pictures."""

from __future__ import annotations

import math

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from autobalancer.flow.ball.mesh import Floats
from autobalancer.flow.ball.slow import Flow

REACH = 4.0  # ball radii to both sides
STEP = 0.04


def plane(flow: Flow) -> tuple[Floats, Floats, Floats]:
    """x, y and the velocity relative to the ball, (2, x, y), in ball radii and its speed; nan in balls and walls, but
    for a strip at their surface."""
    spaces = flow.spaces
    shape, nodes = spaces.shape, spaces.nodes
    on = np.abs(nodes[2]) < 1e-9
    low, high = max(-shape.behind, -REACH), min(shape.ahead, REACH + np.nan_to_num(shape.second))
    seen = nodes[1, on & (nodes[0] > low) & (nodes[0] < high)]
    x, y = (np.linspace(a, b, math.ceil((b - a) / STEP) + 1) for a, b in ((low, high), (seen.min(), seen.max())))
    grid = np.meshgrid(x, y, indexing="ij")
    velocity = (flow.deviation + spaces.walls_velocity())[:2, on]
    found = np.moveaxis(LinearNDInterpolator(nodes[:2, on].T, velocity.T)(*grid), -1, 0)
    depth = shape.depth(*grid)
    out = np.maximum(-depth, depth - shape.width)
    found[0] = np.where(
        out > 0.0, -1.0 - shape.turning * grid[1], found[0]
    )  # a strip of the walls, so that pictures reach them
    found[1] = np.where(out > 0.0, shape.turning * grid[0], found[1])
    outside = out > STEP
    for a, b in shape.centers():
        outside |= np.hypot(grid[0] - a, grid[1] - b) < 1.0 - STEP
    found[:, outside] = np.nan
    return x, y, found

"""How cylinders parallel to the rotor look from any side."""

from __future__ import annotations

import numpy as np
from matplotlib.collections import PolyCollection
from numpy.typing import NDArray

Floats = NDArray[np.float64]
ROUND = np.linspace(0.0, 2.0 * np.pi, 41)[:-1]


def seen_cylinders(camera: Floats, places: Floats, radius: Floats, length: Floats) -> Floats:
    """Outlines (2 n, points, 2) of cylinders at ``places`` (n, 2): of each the whole and the end that faces the eye.

    ``camera`` (3, 3) are the directions right, up and towards the eye; cylinders point along the first axis.
    """
    rim = np.stack(
        [np.outer(np.cos(ROUND), camera[row, 1:2]) + np.outer(np.sin(ROUND), camera[row, 2:]) for row in (0, 1)]
    )
    rim = rim[..., 0].T  # (points, 2) of an end with radius one
    along = camera[:2, 0]
    # an edge of the outline belongs to the end towards which it lies outward
    ahead = np.roll(rim, -1, axis=0) - rim
    outward = np.stack([ahead[:, 1], -ahead[:, 0]], axis=1) * np.sign(camera[2, 0] or 1.0)
    side = np.repeat(np.where(outward @ along > 0.0, 0.5, -0.5), 2)[:, None]
    facing = np.full_like(side, 0.5 * np.sign(camera[2, 0] or 1.0))
    corners = np.stack([rim, np.roll(rim, -1, axis=0)], axis=1).reshape(-1, 2)
    shapes = np.empty((2 * len(places), len(corners), 2))
    for k, ends in enumerate((side, facing)):
        shapes[k::2] = places[:, None] + corners * radius[:, None, None] + ends * along * length[:, None, None]
    return shapes


def rectangles(at: Floats, width: Floats, height: Floats) -> PolyCollection:
    """Rectangles around the places ``at`` (n, 2)."""
    corner = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    size = np.stack([width, height], axis=1)
    return PolyCollection(list(at[:, None] + corner * size[:, None]))

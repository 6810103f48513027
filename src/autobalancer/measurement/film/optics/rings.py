"""Outlines of round things in a picture: balls, and flat round marks.

An outline is the pixels of points around the edge, with the direction outwards in the picture.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from autobalancer.measurement.film.optics.view import View, in_space

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


class Outline(NamedTuple):
    """Edges of several things: (things, points, 2) each, pixels."""

    edge: Floats
    outwards: Floats  # of length one

    def beside(self, distance: float) -> Floats:
        """Pixels so far outside of the edge."""
        return self.edge + distance * self.outwards


def _outwards(edge: Floats) -> Floats:
    """Normals of closed curves from their neighbors, away from their middle."""
    along = np.roll(edge, -1, axis=-2) - np.roll(edge, 1, axis=-2)
    normal = np.stack([along[..., 1], -along[..., 0]], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    side = np.sign((normal * (edge - edge.mean(axis=-2, keepdims=True))).sum(axis=(-1, -2), keepdims=True))
    return np.asarray(normal * side)


def ball_outlines(view: View, places: Complexes, height: float, radius: float, points: int) -> Outline:
    """Outlines of balls whose centers are at ``places`` (x + i y, m) and ``height`` (m)."""
    center = in_space(places, height)
    away = center - view.position
    distance = np.linalg.norm(away, axis=-1, keepdims=True)
    away = away / distance
    first = np.cross(away, [0.0, 1.0, 0.0])
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    second = np.cross(away, first)
    share = radius / distance  # the circle on which rays touch the ball is nearer and smaller
    middle, size = center - radius * share * away, radius * np.sqrt(1.0 - share**2)
    turn = 2.0 * np.pi * np.arange(points) / points
    around = np.cos(turn)[:, None] * first[..., None, :] + np.sin(turn)[:, None] * second[..., None, :]
    edge = view.pixels(middle[..., None, :] + size[..., None] * around)
    return Outline(edge, _outwards(edge))


def mark_outlines(view: View, places: Complexes, height: float, radius: float, points: int) -> Outline:
    """Outlines of flat round marks in the plane at ``height`` (m)."""
    around = radius * np.exp(2j * np.pi * np.arange(points) / points)
    edge = view.pixels(in_space(np.asarray(places)[..., None] + around, height))
    return Outline(edge, _outwards(edge))

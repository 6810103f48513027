"""A pinhole with radial distortion: points of space to pixels and back, plain numbers.

Pixels count to the right and down, the middle of the first one is (0, 0). A pixel from the middle of the picture is
``f (1 + k1 s + k2 s^2) (x, y)`` with ``s = x^2 + y^2`` and ``x, y`` the slopes of the ray from the axis of the lens.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
UNDONE = 8  # iterations that undo a distortion: each gains about two digits


class View(NamedTuple):
    """Where a camera is and how it draws."""

    turn: Floats  # (3, 3): its right, down and forward, as rows
    position: Floats  # (3,) m
    focal_length: float  # pixels
    middle: tuple[float, float]  # pixels, column and row
    distortion: tuple[float, float] = (0.0, 0.0)

    def pixels(self, points: ArrayLike) -> Floats:
        """Pixels (..., 2) of points of space (..., 3)."""
        seen = (np.asarray(points, np.float64) - self.position) @ self.turn.T
        slope = seen[..., :2] / seen[..., 2:]
        k1, k2 = self.distortion
        s = (slope**2).sum(axis=-1, keepdims=True)
        return np.asarray(np.array(self.middle) + self.focal_length * (1.0 + s * (k1 + k2 * s)) * slope)

    def rays(self, pixels: ArrayLike) -> Floats:
        """Directions (..., 3) of length one in space in which pixels (..., 2) look."""
        bent = (np.asarray(pixels, np.float64) - np.array(self.middle)) / self.focal_length
        slope, (k1, k2) = bent, self.distortion
        if k1 or k2:
            for _ in range(UNDONE):
                s = (slope**2).sum(axis=-1, keepdims=True)
                slope = bent / (1.0 + s * (k1 + k2 * s))
        ray = np.concatenate([slope, np.ones_like(slope[..., :1])], axis=-1) @ self.turn
        return np.asarray(ray / np.linalg.norm(ray, axis=-1, keepdims=True))

    def places(self, pixels: ArrayLike, height: float = 0.0) -> Floats:
        """Where (..., 2), m, pixels see the plane at a height (m)."""
        ray = self.rays(pixels)
        reach = (height - self.position[2]) / ray[..., 2:]
        return np.asarray(self.position[:2] + reach * ray[..., :2])


def in_space(places: ArrayLike, height: float) -> Floats:
    """Complex numbers x + i y at a height as points (..., 3)."""
    z = np.asarray(places, np.complex128)
    return np.stack([z.real, z.imag, np.full(z.shape, height)], axis=-1)


def looking(position: ArrayLike, look_at: ArrayLike, roll: float = 0.0) -> Floats:
    """:attr:`View.turn` of a camera that looks at a point; y is up in its picture, turned by ``roll`` (rad)."""
    forward = np.asarray(look_at, np.float64) - np.asarray(position, np.float64)
    forward /= np.linalg.norm(forward)
    up = np.array([0.0, 1.0, 0.0]) if abs(forward[1]) < 0.999 else np.array([0.0, 0.0, 1.0])
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    c, s = np.cos(roll), np.sin(roll)
    return np.array([c * right + s * down, c * down - s * right, forward])


def turned_by(vector: Floats) -> Floats:
    """The matrix of a rotation by a vector (rad), by the formula of Rodrigues."""
    angle = float(np.linalg.norm(vector))
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross))

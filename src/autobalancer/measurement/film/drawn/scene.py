"""How a rotor with a race, balls and marks looks through a camera: brightness of pixels, drawn analytically.

Edges are exact to a small part of a pixel: a pixel on an edge has as much of both sides as it covers.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from autobalancer.measurement.film.optics.view import View, in_space

Singles = NDArray[np.float32]
Complexes = NDArray[np.complex128]

PLATE, DISC, HUB, FLOOR, MARK = 0.16, 0.46, 0.30, 0.22, 0.93  # brightness of what is flat
AMBIENT, DIFFUSE, GLOSS, SHARP = 0.30, 0.48, 0.75, 30.0  # of balls
LIGHT = np.array([0.35, 0.45, 0.82]) / np.linalg.norm([0.35, 0.45, 0.82])
STEPS = 4096  # of the table of brightness over the radius


class Things(NamedTuple):
    """Where everything is at one instant, in the frame of the camera, m."""

    center: complex  # of the rotor
    balls: Complexes
    rotor_marks: Complexes
    frame_marks: Complexes
    light: NDArray[np.float64]


class Sizes(NamedTuple):
    """What does not change, m."""

    orbit: float
    ball: float  # radius
    ball_height: float  # of its center above the marks
    disc: float
    rotor_mark: float
    frame_mark: float


class Painter:
    """Draws instants of one scene through one view."""

    def __init__(self, view: View, width: int, height: int, sizes: Sizes) -> None:
        self.view, self.sizes = view, sizes
        columns, rows = np.meshgrid(np.arange(width, dtype=np.float64), np.arange(height, dtype=np.float64))
        rays = view.rays(np.stack([columns, rows], axis=-1))
        self.rays = np.ascontiguousarray(np.moveaxis(rays, -1, 0), np.float32)
        reach = np.where(rays[..., 2] < -1e-3, -view.position[2] / np.minimum(rays[..., 2], -1e-3), 1e3)
        self.x = (view.position[0] + reach * rays[..., 0]).astype(np.float32)
        self.y = (view.position[1] + reach * rays[..., 1]).astype(np.float32)
        self.pixel = float(np.linalg.norm(view.position)) / view.focal_length  # m in one pixel
        self._far = 1.3 * sizes.disc
        self._table = self._profile()
        self._ground: tuple[complex, Singles] | None = None

    def _profile(self) -> Singles:
        """Brightness over the radius, with edges as wide as a pixel."""
        s, radius = self.sizes, np.linspace(0.0, self._far, STEPS)
        level = np.full(STEPS, HUB)
        wide = 1.15 * s.ball
        edges = ((0.3 * s.orbit, DISC), (s.orbit - wide, FLOOR), (s.orbit + wide, DISC), (s.disc, PLATE))
        before = HUB
        for edge, after in edges:
            level += (after - before) * np.clip((radius - edge) / self.pixel + 0.5, 0.0, 1.0)
            before = after
        return level.astype(np.float32)

    def ground(self, center: complex) -> Singles:
        """Plate, disc and race without marks and balls; kept while the rotor does not move."""
        if self._ground is None or abs(self._ground[0] - center) > 0.005 * self.pixel:
            dx, dy = self.x - np.float32(center.real), self.y - np.float32(center.imag)
            radius = np.sqrt(dx * dx + dy * dy)
            place = np.minimum(radius * np.float32((STEPS - 1) / self._far), np.float32(STEPS - 1.001))
            low = place.astype(np.int32)
            share = place - low
            self._ground = (center, self._table[low] * (1.0 - share) + self._table[low + 1] * share)
        return self._ground[1]

    def add(self, picture: Singles, things: Things) -> None:
        """Draw marks and balls into a picture of the ground."""
        for places, radius in (
            (things.frame_marks, self.sizes.frame_mark),
            (things.rotor_marks, self.sizes.rotor_mark),
        ):
            for mark in places:
                self._mark(picture, complex(mark), radius)
        height = self.sizes.ball_height
        points = in_space(things.balls, height)
        far = np.linalg.norm(points - self.view.position, axis=-1)
        for number in np.argsort(-far):  # the nearest last
            self._ball(picture, points[number], float(far[number]), things.light)

    def _patch(self, point: NDArray[np.float64], radius: float, picture: Singles) -> tuple[slice, slice]:
        column, row = self.view.pixels(point)
        reach = 1.3 * radius * self.view.focal_length / float(np.linalg.norm(point - self.view.position)) + 3.0
        rows = slice(max(0, int(row - reach)), max(0, min(picture.shape[0], int(row + reach) + 2)))
        return rows, slice(max(0, int(column - reach)), max(0, min(picture.shape[1], int(column + reach) + 2)))

    def _mark(self, picture: Singles, place: complex, radius: float) -> None:
        part = self._patch(in_space(place, 0.0), radius, picture)
        away = np.hypot(self.x[part] - np.float32(place.real), self.y[part] - np.float32(place.imag))
        cover = np.clip((radius - away) / self.pixel + 0.5, 0.0, 1.0)
        picture[part] += cover * (MARK - picture[part])

    def _ball(self, picture: Singles, point: NDArray[np.float64], far: float, light: NDArray[np.float64]) -> None:
        """A shaded ball with its highlight: rays that pass within its radius hit it."""
        radius = self.sizes.ball
        part = self._patch(point, radius, picture)
        ray = self.rays[(slice(None), *part)]
        away = (point - self.view.position).astype(np.float32)
        along = np.tensordot(away, ray, axes=1)
        squared = np.maximum(np.float32(far) ** 2 - along * along, 0.0)
        cover = np.clip((radius - np.sqrt(squared)) * (self.view.focal_length / far) + 0.5, 0.0, 1.0)
        depth = along - np.sqrt(np.maximum(radius**2 - squared, 0.0))
        normal = (ray * depth - away[:, None, None]) / np.float32(radius)
        half = light - away / far
        half /= np.linalg.norm(half)
        lit = np.maximum(np.tensordot(light.astype(np.float32), normal, axes=1), 0.0)
        shine = np.maximum(np.tensordot(half.astype(np.float32), normal, axes=1), 0.0) ** SHARP
        picture[part] += cover * (AMBIENT + DIFFUSE * lit + GLOSS * shine - picture[part])

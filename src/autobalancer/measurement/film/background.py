"""How the race looks without balls: the same all around the axis but for the light, which changes slowly around it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from autobalancer.measurement.film.edges import sampled
from autobalancer.measurement.film.optics.view import View, in_space
from autobalancer.measurement.film.setup import FilmSetup

Floats = NDArray[np.float64]
Gray = NDArray[np.uint8]
ANGLES = 180
REACH = 3.0  # ball radii inside and outside of the orbit
WAVES = 2  # of the light around the axis


class Background:
    """Brightness of the race over the radius, the median around the axis, times the light over the angle."""

    def __init__(self, view: View, setup: FilmSetup, pictures: Sequence[Gray], centers: Sequence[complex]) -> None:
        self.view = view
        pixel = float(np.linalg.norm(view.position)) / view.focal_length
        half = 0.5 * REACH * setup.diameter
        count = int(np.clip(2.0 * half / (0.4 * pixel), 8, 400))
        self.radius = np.linspace(max(setup.orbit - half, 0.02 * setup.orbit), setup.orbit + half, count)
        angle = 2.0 * np.pi * np.arange(ANGLES) / ANGLES
        circles = self.radius[:, None] * np.exp(1j * angle)
        seen = np.array(
            [sampled(one, view.pixels(in_space(at + circles, 0.0))) for one, at in zip(pictures, centers, strict=True)]
        )
        level = np.median(seen, axis=(0, 2))
        waves = _waves(angle)
        share = np.median(seen, axis=0) / np.maximum(level, 1.0)[:, None]
        self.light = np.linalg.lstsq(waves, np.median(share, axis=0), rcond=None)[0]
        light = waves @ self.light
        self.level = np.median(seen / np.maximum(light, 0.1), axis=(0, 2))

    def at(self, pixels: Floats, center: complex) -> Floats:
        """Brightness of pixels (..., 2), of 255, if no ball were there."""
        place = self.view.places(pixels)
        z = place[..., 0] + 1j * place[..., 1] - center
        return np.asarray(np.interp(np.abs(z), self.radius, self.level) * (_waves(np.angle(z)) @ self.light))


def _waves(angle: Floats) -> Floats:
    rows = [np.ones_like(angle)]
    for k in range(1, WAVES + 1):
        rows += [np.cos(k * angle), np.sin(k * angle)]
    return np.stack(rows, axis=-1)

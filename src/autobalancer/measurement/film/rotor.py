"""The angle of the rotor and where its axis is, in each picture, from the marks that turn with it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from autobalancer.measurement.film.edges import located, sampled
from autobalancer.measurement.film.marks import Mark, places_of
from autobalancer.measurement.film.optics.rings import mark_outlines
from autobalancer.measurement.film.optics.view import View, in_space
from autobalancer.measurement.film.search import Circle, circle, peaks, steps_around

Floats = NDArray[np.float64]
Gray = NDArray[np.uint8]
POINTS = 40
LEAST = 0.5  # share of the edges of a mark that must agree


class RotorPlace(NamedTuple):
    """Where the rotor is in one picture."""

    angle: float  # rad, in space; nan if unknown
    center: complex  # m
    deviation: float  # rad, of the angle


UNKNOWN = RotorPlace(np.nan, 0j, np.nan)


class RotorMarks:
    """Looks for marks of known place on the rotor."""

    def __init__(self, view: View, marks: tuple[Mark, ...]) -> None:
        self.view, self.marks = view, marks
        self.places = places_of(marks)
        self.radius = float(marks[0].radius)
        radii, which = np.unique(np.round(np.abs(self.places), 9), return_inverse=True)
        pixel = float(np.linalg.norm(view.position)) / view.focal_length
        self.steps = steps_around(float(radii.max()) / pixel)
        around = np.exp(2j * np.pi * np.arange(self.steps) / self.steps)
        away = max(1.6, 0.5 * self.radius / pixel)  # the axis may be off by as much
        self.circles: list[Circle] = [
            circle(mark_outlines(view, r * around, 0.0, self.radius, 24), away) for r in radii
        ]
        self.which = np.atleast_1d(which)

    def coarse(self, picture: Gray) -> float:
        """The angle at which all marks together are most marked; nan if no angle is by far the best."""
        scores = [one.scores(picture) for one in self.circles]
        total = np.zeros(self.steps)
        for place, which in zip(self.places, self.which, strict=True):
            turn = np.angle(place) / (2.0 * np.pi) * self.steps
            total += np.interp(
                np.arange(self.steps) + turn, np.arange(2 * self.steps), np.tile(scores[which], 2), period=self.steps
            )
        size = abs(total)
        apart = 4.0 * self.radius / float(np.abs(self.places).max())
        at, heights = peaks(size, apart, 2)
        if at.size == 0 or heights[0] < 4.0 * len(self.marks) or (at.size > 1 and heights[1] > 0.8 * heights[0]):
            return np.nan
        return float(at[0])

    def found(self, picture: Gray, noise: float) -> RotorPlace:
        """Angle and axis by the edges of the marks."""
        angle, center = self.coarse(picture), 0j
        if np.isnan(angle):
            return UNKNOWN
        deviation = np.nan
        angle, center = self._rough(picture, angle)
        for _ in range(3):
            where = center + self.places * np.exp(1j * angle)
            outline = mark_outlines(self.view, where, 0.0, self.radius, POINTS)
            edge = located(picture, outline, rises=False, noise=noise, usable=np.ones(outline.edge.shape[:2], np.bool_))
            good = edge.share >= LEAST
            if not good.any() or (len(self.marks) > 1 and good.sum() < 2):
                return UNKNOWN
            moved = self.view.places(self.view.pixels(in_space(where, 0.0)) + edge.shift)
            z = (moved[:, 0] + 1j * moved[:, 1])[good]
            pixel = float(np.linalg.norm(self.view.position)) / self.view.focal_length
            spread = np.sqrt(np.trace(edge.covariance, axis1=1, axis2=2)[good] / 2.0) * pixel
            angle, center, deviation = _fitted(self.places[good], z, spread, angle, center)
        return RotorPlace(angle, center, deviation)

    def _rough(self, picture: Gray, angle: float) -> tuple[float, complex]:
        """Angle and axis by the middles of light or dark: the axis may be off by half the size of a mark and more."""
        center = 0j
        for _ in range(2):
            z = center + self.places * np.exp(1j * angle)
            grid = self.view.places(self._middles(picture, self.view.pixels(in_space(z, 0.0))))
            found = grid[:, 0] + 1j * grid[:, 1]
            angle, center, _ = _fitted(self.places, found, np.ones(found.size), angle, center)
        return angle, center

    def _middles(self, picture: Gray, pixels: Floats) -> Floats:
        """Middles of what differs from its surroundings in windows about pixels."""
        reach = 1.9 * self.radius * self.view.focal_length / float(np.linalg.norm(self.view.position)) + 2.0
        step = np.linspace(-reach, reach, 25)
        away = np.stack(np.meshgrid(step, step), axis=-1).reshape(-1, 2)
        seen = sampled(picture, pixels[:, None, :] + away).astype(np.float64)
        seen = np.abs(seen - np.median(seen, axis=1, keepdims=True))
        weight = np.maximum(seen - 0.5 * seen.max(axis=1, keepdims=True), 0.0) + 1e-9
        return np.asarray(pixels + np.einsum("mk,ki->mi", weight, away) / weight.sum(axis=1, keepdims=True))


def _fitted(
    marks: NDArray[np.complex128], z: NDArray[np.complex128], spread: Floats, angle: float, center: complex
) -> tuple[float, complex, float]:
    """Rotation and shift that take marks to where they were found; of one mark the rotation alone."""
    weight = 1.0 / spread**2
    if marks.size == 1:
        return (
            angle + float(np.angle((z[0] - center) / (marks[0] * np.exp(1j * angle)))),
            center,
            float(spread[0] / abs(marks[0])),
        )
    middle_marks, middle_z = (weight * marks).sum() / weight.sum(), (weight * z).sum() / weight.sum()
    turn = (weight * (z - middle_z) * np.conj(marks - middle_marks)).sum()
    turned = angle + float(np.angle(turn / abs(turn) * np.exp(-1j * angle)))
    lever = (weight * abs(marks - middle_marks) ** 2).sum()
    return turned, complex(middle_z - middle_marks * np.exp(1j * turned)), float(1.0 / np.sqrt(lever))

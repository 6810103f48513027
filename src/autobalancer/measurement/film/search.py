"""Round things on a circle, looked for all around it: where a ring of their size separates light from dark."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from autobalancer.measurement.film.edges import sampled
from autobalancer.measurement.film.optics.rings import Outline

Floats = NDArray[np.float64]
Gray = NDArray[np.uint8]
POINTS = 24  # of a ring
AWAY = 1.6  # pixels inside and outside of the edge


class Circle(NamedTuple):
    """Rings all around a circle, at equal steps from angle zero."""

    inner: NDArray[np.float64]
    outer: NDArray[np.float64]

    def scores(self, picture: Gray, shift: Floats | float = 0.0) -> Floats:
        """Mean step from outside to inside of each ring, all shifted by some pixels, of 255, less that without things."""
        step = sampled(picture, self.inner + shift) - sampled(picture, self.outer + shift)
        score = step.mean(axis=-1).astype(np.float64)
        return np.asarray(score - np.median(score))


def circle(outline: Outline, away: float = AWAY) -> Circle:
    """Rings from the outlines of a thing at all places of a circle, so many pixels inside and outside."""
    return Circle(outline.beside(-away), outline.beside(away))


def steps_around(radius_in_pixels: float) -> int:
    """Number of places on a circle, a little more than a pixel apart."""
    return int(np.clip(2.0 * np.pi * radius_in_pixels / 1.2, 240, 2400))


def peaks(score: Floats, apart: float, most: int) -> tuple[Floats, Floats]:
    """Angles (rad) and heights of the highest peaks at least ``apart`` (rad) from each other, the highest first."""
    count = score.size
    top = (score >= np.roll(score, 1)) & (score > np.roll(score, -1))
    places = np.flatnonzero(top)
    places = places[np.argsort(-score[places], kind="stable")]
    kept: list[int] = []
    step = 2.0 * np.pi / count
    for place in places:
        gaps = [abs((place - other + count // 2) % count - count // 2) * step for other in kept]
        if all(gap >= apart for gap in gaps):
            kept.append(int(place))
        if len(kept) == most:
            break
    at = np.array(kept, np.intp)
    before, here, after = score[at - 1], score[at], score[(at + 1) % count]
    bend = np.minimum(before - 2.0 * here + after, -1e-12)
    return np.asarray((at + np.clip(0.5 * (before - after) / bend, -0.5, 0.5)) * step), np.asarray(here)

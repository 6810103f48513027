"""Marks found in a picture near where somebody said they are, and the camera that sees them there."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from autobalancer.errors import QuestionError
from autobalancer.measurement.film.edges import located
from autobalancer.measurement.film.marks import Mark, places_of
from autobalancer.measurement.film.optics.calibration import FLOOR, Calibration, calibrate
from autobalancer.measurement.film.optics.rings import mark_outlines
from autobalancer.measurement.film.setup import FilmSetup

Floats = NDArray[np.float64]
Gray = NDArray[np.uint8]
POINTS = 48  # around the edge
TOGETHER = 3  # marks are found and the camera fitted so often


def noise_of(picture: Gray) -> float:
    """Standard deviation of a pixel, of 255: from differences of neighbors, few of which are edges."""
    rows = picture[::7].astype(np.float64)
    second = rows[:, 2:] - 2.0 * rows[:, 1:-1] + rows[:, :-2]
    return max(float(1.4826 * np.median(np.abs(second)) / np.sqrt(6.0)), 0.4)


def camera_of(picture: Gray, setup: FilmSetup) -> Calibration:
    """The camera from the marks that do not move.

    Raises
    ------
    QuestionError
        If a mark is not where it was said to be, or the marks fit to no camera.
    """
    marks, size = setup.marks, (picture.shape[1], picture.shape[0])
    given = np.array([mark.pixel for mark in marks], np.float64)
    for number, (column, row) in enumerate(given, 1):
        if not (0.0 <= column < size[0] and 0.0 <= row < size[1]):
            raise QuestionError(
                f"mark {number}: pixel ({column:g}, {row:g}) is outside of the picture of {size[0]} x {size[1]}"
            )
    places = places_of(marks)

    def fitted(pixels: Floats, deviation: float) -> Calibration:
        return calibrate(
            places, pixels, size, focal_length=setup.focal_length, distortion=setup.distortion, deviation=deviation
        )

    if setup.marks_exact:
        return fitted(given, setup.pixel_deviation)
    rough = float(np.mean(np.abs(np.diff(given[:, 0] + 1j * given[:, 1]))) / np.mean(np.abs(np.diff(places))))
    noise = noise_of(picture)
    pixels = np.array(
        [_spot(picture, mark, at, rough, noise, n) for n, (mark, at) in enumerate(zip(marks, given, strict=True), 1)]
    )
    found = fitted(pixels, 0.5)
    for _ in range(TOGETHER):
        pixels = _edges(picture, marks, found, noise)
        found = fitted(pixels, FLOOR)
    return found


def _spot(picture: Gray, mark: Mark, at: Floats, scale: float, noise: float, number: int) -> Floats:
    """Middle of the spot that differs most from what is around it, near a pixel."""
    reach = int(max(10.0, 3.0 * float(mark.radius) * scale))
    column, row = np.round(at).astype(int)
    up, left = max(0, row - reach), max(0, column - reach)
    part = ndimage.gaussian_filter(picture[up : row + reach + 1, left : column + reach + 1].astype(np.float64), 0.7)
    away = part - np.median(part)
    most = away.max() if away.max() > -away.min() else away.min()
    if abs(most) < max(6.0 * noise, 8.0):
        raise QuestionError(
            f"mark {number}: no spot within {reach} pixels of ({at[0]:g}, {at[1]:g}); check its pixel, or that the film "
            "shows marks"
        )
    labels, count = ndimage.label(away / most > 0.5)
    middles = np.array(ndimage.center_of_mass(away / most, labels, range(1, count + 1)))[:, ::-1] + (left, up)
    sizes = ndimage.sum_labels(labels > 0, labels, range(1, count + 1))
    far = np.linalg.norm(middles - at, axis=1) + np.where(sizes < 0.2 * sizes.max(), 1e3, 0.0)
    return np.asarray(middles[far.argmin()], np.float64)


def _edges(picture: Gray, marks: Sequence[Mark], found: Calibration, noise: float) -> Floats:
    """Middles of marks by their edges."""
    pixels = []
    for number, mark in enumerate(marks, 1):
        place = np.array([mark.z])
        outline = mark_outlines(found.view, place, 0.0, float(mark.radius), POINTS)
        edge = located(picture, outline, rises=False, noise=noise, usable=np.ones((1, POINTS), np.bool_))
        if not edge.share[0] >= 0.4:
            raise QuestionError(
                f"mark {number}: its edge is not a circle of radius {float(mark.radius):g} m where the other marks say that it "
                "is; check its pixel, its place and its radius"
            )
        middle = found.view.pixels(np.array([mark.z.real, mark.z.imag, 0.0]))
        pixels.append(middle + edge.shift[0])
    return np.array(pixels)

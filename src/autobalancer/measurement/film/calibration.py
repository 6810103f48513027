"""Where the camera stood and how its lens draws, from marks of known place in a picture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage
from scipy.optimize import least_squares

from autobalancer.errors import QuestionError
from autobalancer.measurement.film.optics import View, in_space, located, mark_outlines, turned_by
from autobalancer.measurement.film.setup import FilmSetup, Mark, places_of

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
USUAL, SPREAD = (
    1.6,
    0.7,
)  # focal lengths of cameras over the width of the picture, and the standard deviation of their logarithm
BENT = 0.3  # standard deviation of distortion before anything is known
FLOOR = 0.03  # pixels: marks are not found better than this


class Calibration(NamedTuple):
    """A view with the covariance of what was fitted."""

    view: View
    covariance: Floats  # of rotation (3, rad), position (3, m), logarithm of the focal length and distortion terms
    residual: float  # pixels, root mean square of the marks

    def moved(self, change: Floats) -> View:
        """The view with other fitted numbers."""
        return _changed(self.view, change)

    def angle_deviation(self, places: Complexes, height: float, center: complex) -> Floats:
        """Standard deviation (rad) of angles about ``center`` of points at ``places`` (m) and ``height``, by the marks alone."""
        pixels = self.view.pixels(in_space(places, height))
        size = self.covariance.shape[0]
        deviation = np.sqrt(np.maximum(np.diag(self.covariance), 1e-30))
        slope = np.empty((size, len(places)))
        for i in range(size):
            step = np.zeros(size)
            step[i] = 0.1 * deviation[i]
            ahead, behind = (_complex(self.moved(s).places(pixels, height)) for s in (step, -step))
            slope[i] = np.angle((ahead - center) / (behind - center)) / (2.0 * step[i])
        return np.asarray(np.sqrt(np.maximum(np.einsum("ik,ij,jk->k", slope, self.covariance, slope), 0.0)))


def calibrate(
    places: Complexes,
    pixels: ArrayLike,
    size: tuple[int, int],
    *,
    focal_length: float | None = None,
    distortion: int | Sequence[float] = 0,
    deviation: float = FLOOR,
) -> Calibration:
    """Fit the camera to marks in one plane.

    Parameters
    ----------
    places
        Of the marks as x + i y, m.
    pixels
        Where they are in the picture, (marks, 2).
    size
        Columns and rows of the picture; the lens is taken to point at its middle.
    focal_length
        Pixels; by default fitted, which an oblique view allows. Seen straight from above it stays between half and five widths of
        the picture, and the deviations contain that.
    distortion
        Number of radial terms to fit (0, 1 or 2), or the known terms.
    deviation
        Least standard deviation of a mark, pixels; the residuals may say that it is more.

    Raises
    ------
    QuestionError
        If there are too few marks, they are degenerate, or do not fit to any camera.
    """
    u = np.asarray(pixels, np.float64)
    terms = distortion if isinstance(distortion, int) else 0
    known = (0.0, 0.0) if isinstance(distortion, int) else (*map(float, distortion), 0.0, 0.0)[:2]
    if not 0 <= terms <= 2:
        raise QuestionError(f"distortion: given {distortion}; 0, 1 or 2 terms can be fitted")
    free = 6 + (focal_length is None) + terms
    if 2 * len(u) < free + 1 and len(u) != 4:
        raise QuestionError(
            f"{len(u)} marks: {free} numbers of the camera are unknown; give at least {(free + 2) // 2} marks"
        )
    first = _first(places, u, size, focal_length, known)

    def miss(change: Floats) -> Floats:
        view = _changed(first, _whole(change, focal_length is None))
        away = (view.pixels(in_space(places, 0.0)) - u).ravel() / deviation
        prior = [] if focal_length is not None else [np.log(view.focal_length / (USUAL * size[0])) / SPREAD]
        return np.concatenate([away, prior, change[6 + (focal_length is None) :] / BENT])

    scale = np.array([1e-2] * 3 + [1e-2 * float(np.linalg.norm(first.position))] * 3 + [0.1] * (free - 6))
    solution = least_squares(miss, np.zeros(free), x_scale=scale, method="trf", max_nfev=200)
    view = _changed(first, _whole(solution.x, focal_length is None))
    away = view.pixels(in_space(places, 0.0)) - u
    residual = float(np.sqrt((away**2).mean()))
    if not np.isfinite(residual) or residual > 0.05 * size[1]:
        raise QuestionError(
            f"marks: no camera sees them where they are in the picture; they miss by {residual:.3g} pixels. Check places "
            "and order"
        )
    freedom = max(2 * len(u) - free, 1)
    worse = max(1.0, float((away**2).sum()) / freedom / deviation**2) if 2 * len(u) > free else 1.0
    covariance = np.linalg.pinv(solution.jac.T @ solution.jac, rcond=1e-15) * worse
    if focal_length is not None:
        covariance = np.insert(np.insert(covariance, 6, 0.0, axis=0), 6, 0.0, axis=1)
    return Calibration(view, covariance, residual)


def _whole(change: Floats, focal: bool) -> Floats:
    return change if focal else np.insert(change, 6, 0.0)


def _changed(view: View, change: Floats) -> View:
    k1, k2 = view.distortion
    more = (*change[7:], 0.0, 0.0)[:2]
    return View(
        view.turn @ turned_by(change[:3]),
        view.position + change[3:6],
        view.focal_length * float(np.exp(np.clip(change[6], -3.0, 3.0))),
        view.middle,
        (k1 + float(more[0]), k2 + float(more[1])),
    )


def _first(places: Complexes, u: Floats, size: tuple[int, int], focal: float | None, known: tuple[float, ...]) -> View:
    """Camera of the homography: its first two columns are those of a rotation, Zhang (2000)."""
    middle = (0.5 * (size[0] - 1), 0.5 * (size[1] - 1))
    h = homography(np.column_stack([places.real, places.imag]), u)
    c = np.array([[1.0, 0.0, -middle[0]], [0.0, 1.0, -middle[1]], [0.0, 0.0, 1.0]]) @ h
    if focal is None:
        along = np.array([c[0, 0] * c[0, 1] + c[1, 0] * c[1, 1], (c[:2, 0] ** 2).sum() - (c[:2, 1] ** 2).sum()])
        across = np.array([c[2, 0] * c[2, 1], c[2, 0] ** 2 - c[2, 1] ** 2])
        inverse = -float(along @ across) / max(float(along @ along), 1e-300)
        focal = float(np.clip(inverse**-0.5 if inverse > 0.0 else np.inf, 0.5 * size[0], 5.0 * size[0]))
    b = np.diag([1.0 / focal, 1.0 / focal, 1.0]) @ c
    b /= 0.5 * (np.linalg.norm(b[:, 0]) + np.linalg.norm(b[:, 1]))
    b *= 1.0 if b[2, 2] > 0.0 else -1.0  # the marks are in front of the camera
    turn = np.column_stack([b[:, 0], b[:, 1], np.cross(b[:, 0], b[:, 1])])
    left, _, right = np.linalg.svd(turn)
    turn = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    position = -turn.T @ b[:, 2]
    if position[2] <= 0.0:
        raise QuestionError(
            "marks: the camera would be below the rotor, so the picture or the order of the marks is mirrored; places count "
            "counterclockwise as the camera sees them"
        )
    return View(turn, position, focal, middle, (known[0], known[1]))


def _complex(places: Floats) -> Complexes:
    return np.asarray(places[..., 0] + 1j * places[..., 1])


# The projective map of a plane onto a picture, from marks: Hartley and Zisserman (2004), section 4.1, normalized.


FLAT = 1e-3  # least spread of the marks across their line, over that along it


def homography(places: ArrayLike, pixels: ArrayLike) -> Floats:
    """The matrix H that maps places of a plane to pixels, ``(u, v, 1) ~ H (x, y, 1)``, for four or more marks.

    Parameters
    ----------
    places
        x, y of the marks, (marks, 2), m.
    pixels
        Columns and rows in the picture, (marks, 2).

    Returns
    -------
    numpy.ndarray
        (3, 3), of length one.

    Raises
    ------
    QuestionError
        If there are fewer than four marks, or all but one of them lie on a line.
    """
    x, u = np.asarray(places, np.float64), np.asarray(pixels, np.float64)
    if x.ndim != 2 or x.shape != u.shape or x.shape[-1] != 2 or x.shape[0] < 4:
        raise QuestionError(
            f"homography: places {x.shape} and pixels {u.shape}; give four or more marks, two numbers each, for both"
        )
    if not (np.isfinite(x).all() and np.isfinite(u).all()):
        raise QuestionError("homography: a place or a pixel is not a finite number")
    for name, points in (("places", x), ("pixels", u)):
        if _degenerate(points):
            raise QuestionError(
                f"homography: the {name} of all marks but at most one lie on a line, or coincide; four marks must be corners of "
                "a quadrangle"
            )
    a, b = _centered(x), _centered(u)
    p, q = mapped(a, x), mapped(b, u)
    one, zero = np.ones(len(p)), np.zeros((len(p), 3))
    row = np.column_stack([p, one])
    system = np.vstack([np.hstack([row, zero, -q[:, :1] * row]), np.hstack([zero, row, -q[:, 1:] * row])])
    h = np.linalg.svd(system)[2][-1].reshape(3, 3)
    h = np.linalg.solve(b, h @ a)
    return np.asarray(h / np.linalg.norm(h) * np.sign(_apply_weight(h, x)))


def mapped(h: Floats, points: Floats) -> Floats:
    """Where a projective map takes points (..., 2)."""
    moved = points @ h[:, :2].T + h[:, 2]
    return np.asarray(moved[..., :2] / moved[..., 2:])


def _apply_weight(h: Floats, points: Floats) -> float:
    return float((points @ h[2, :2] + h[2, 2]).sum())


def _centered(points: Floats) -> Floats:
    """Moves the middle to zero, and the mean distance to the root of two."""
    middle = points.mean(axis=0)
    scale = np.sqrt(2.0) / np.linalg.norm(points - middle, axis=1).mean()
    return np.array([[scale, 0.0, -scale * middle[0]], [0.0, scale, -scale * middle[1]], [0.0, 0.0, 1.0]])


def _degenerate(points: Floats) -> bool:
    """Whether fewer than four points are in general position: leaving out any one, the others lie on a line."""
    for left_out in range(len(points)):
        rest = np.delete(points, left_out, axis=0)
        spread = np.linalg.svd(rest - rest.mean(axis=0), compute_uv=False)
        if spread[1] <= FLAT * max(spread[0], 1e-300):
            return True
    return False


# Marks found in a picture near where somebody said they are, and the camera that sees them there.


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
    camera = fitted(pixels, 0.5)
    for _ in range(TOGETHER):
        pixels = _edges(picture, marks, camera, noise)
        camera = fitted(pixels, FLOOR)
    return camera


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


def _edges(picture: Gray, marks: Sequence[Mark], calibration: Calibration, noise: float) -> Floats:
    """Middles of marks by their edges."""
    pixels = []
    for number, mark in enumerate(marks, 1):
        place = np.array([mark.z])
        outline = mark_outlines(calibration.view, place, 0.0, float(mark.radius), POINTS)
        edge = located(picture, outline, rises=False, noise=noise, usable=np.ones((1, POINTS), np.bool_))
        if not edge.share[0] >= 0.4:
            raise QuestionError(
                f"mark {number}: its edge is not a circle of radius {float(mark.radius):g} m where the other marks say that it "
                "is; check its pixel, its place and its radius"
            )
        middle = calibration.view.pixels(np.array([mark.z.real, mark.z.imag, 0.0]))
        pixels.append(middle + edge.shift[0])
    return np.array(pixels)

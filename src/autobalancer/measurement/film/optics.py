"""From marks to the camera, and outlines of round things as it sees them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from autobalancer.arrays import Complexes, Floats
from autobalancer.errors import QuestionError
from autobalancer.measurement.film.setup import FilmSetup, Mark, places_of

# A pinhole with radial distortion: points of space to pixels and back, plain numbers.
#
# Pixels count to the right and down, the middle of the first one is (0, 0). A pixel from the middle of the picture is
# ``f (1 + k1 s + k2 s^2) (x, y)`` with ``s = x^2 + y^2`` and ``x, y`` the slopes of the ray from the axis of the lens.


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


# Outlines of round things in a picture: balls, and flat round marks.
#
# An outline is the pixels of points around the edge, with the direction outwards in the picture.


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


# Round things found to a small part of a pixel, by their edges.
#
# Across the edge of a ball the brightness is a step, behind which it rises with the root of the depth, because there
# the surface turns away from the camera; behind the edge of a flat mark it does not rise. For each ray across an edge
# the place is found at which such a profile fits best, whatever the light; the rays together, robustly, give the
# center.


INSIDE, OUTSIDE, STEP = 3.5, 3.0, 0.5  # pixels along a ray
SHIFTS = np.arange(-2.4, 2.401, 0.1)  # pixels outwards that are tried
BLUR = 0.6  # pixels: half width of the edge that a camera makes
TUKEY = 4.7
MODEL = 0.1  # pixels: no edge has quite such a profile
FLOOR, SHADED = 0.01, 0.07  # pixels: flat marks are found no better, and shaded balls
LARGE = 11.0  # pixels: of smaller balls a ray sees so much that the profile near the edge is no longer theirs
SHARED = 1.5  # pixels: rays nearer to each other see the same noise
# Pixels by which half of the rays miss a ball of the known size, without what noise does: of shaded balls at most the first; from
# the second on what was found is something that the ball mirrors, and the ball is anywhere within a share of its radius. Found
# with drawn mirrors.
ALIKE, UNLIKE, GROWTH, ANYWHERE = 0.15, 0.4, 1.8, 0.42
NORMAL = 1.4826  # standard deviation of normal deviates over the median of their sizes
FAINT = 10.0  # least contrast of an edge that still counts by it, share of the clear ones


class OutlineShifts(NamedTuple):
    """Shifts of things from where they were looked for."""

    shift: Floats  # (things, 2) pixels
    covariance: Floats  # (things, 2, 2)
    share: Floats  # of the rays that agree
    contrast: Floats  # brightness across the edge, of 255
    misfit: Floats  # pixels from a thing of the known size, median over all rays that count


def sampled(picture: NDArray[np.uint8], pixels: Floats) -> NDArray[np.float32]:
    """Brightness between pixels, linear; outside of the picture that of its border, where no pixel is seen that of a corner."""
    at = np.moveaxis(np.nan_to_num(pixels)[..., ::-1], -1, 0)
    return np.asarray(ndimage.map_coordinates(picture, at, np.float32, order=1, mode="nearest"), np.float32)


@cache
def _profiles(rises: bool) -> tuple[Floats, Floats, Floats, Floats]:
    """Offsets along a ray; for each shift what a thing covers of each pixel, what a profile leaves of a ray, and its step."""
    offset = np.arange(-INSIDE, OUTSIDE + 0.5 * STEP, STEP)
    left, step, cover = [], [], []
    fine = np.linspace(-2.5 * BLUR, 2.5 * BLUR, 41)
    weight = np.exp(-0.5 * (fine / BLUR) ** 2)
    weight /= weight.sum()
    for shift in SHIFTS:
        depth = shift - offset[:, None] + fine
        covered = (depth > 0.0) @ weight
        shapes = [np.ones(offset.size), covered]
        if rises:
            shapes.append(np.sqrt(np.maximum(depth, 0.0)) @ weight)
        shape = np.stack(shapes, axis=1)
        inverse = np.linalg.pinv(shape)
        left.append(np.eye(offset.size) - shape @ inverse)
        step.append(inverse[1])
        cover.append(covered)
    return offset, np.array(cover), np.array(left), np.array(step)


def located(
    picture: NDArray[np.uint8],
    outline: Outline,
    *,
    rises: bool,
    noise: float,
    usable: NDArray[np.bool_],
    behind: Callable[[Floats], Floats] | None = None,
) -> OutlineShifts:
    """Shift of each outline that fits best.

    Parameters
    ----------
    picture
        Brightness from 0 to 255.
    outline
        Where edges are expected.
    rises
        Whether things are round like a ball, or flat.
    noise
        Standard deviation of a pixel, of 255.
    usable
        Which rays count, (things, points).
    behind
        What pixels would show without the things, but for a constant on each ray; by default the same all along a ray.
    """
    offset, cover, left, step = _profiles(rises)
    pixels = outline.edge[..., None, :] + offset[:, None] * outline.outwards[..., None, :]
    ray = sampled(picture, pixels).astype(np.float64)[..., None, :]
    if behind is not None:
        ray = ray - behind(pixels)[..., None, :] * (1.0 - cover)
        miss = (np.einsum("skl,tpsl->tpsk", left, ray, optimize=True) ** 2).sum(axis=-1)
    else:
        miss = (np.einsum("skl,tpl->tpsk", left, ray[..., 0, :], optimize=True) ** 2).sum(axis=-1)
    best = miss.argmin(axis=-1)
    inner = np.clip(best, 1, SHIFTS.size - 2)
    before, at, after = (np.take_along_axis(miss, inner[..., None] + k, axis=-1)[..., 0] for k in (-1, 0, 1))
    bend = np.maximum(before - 2.0 * at + after, 1e-12)
    gap = SHIFTS[1] - SHIFTS[0]
    place = SHIFTS[inner] + gap * np.clip(0.5 * (before - after) / bend, -1.0, 1.0)
    spread = np.maximum(at / (offset.size - 3 - rises), noise**2)
    own = np.take_along_axis(ray, np.minimum(inner, ray.shape[-2] - 1)[..., None, None], axis=-2)[..., 0, :]
    contrast = np.abs(np.einsum("tpk,tpk->tp", step[inner], own))
    wrong = MODEL * _faintness(contrast, usable) if rises else MODEL
    weight = 1.0 / (
        gap**2 * spread / (0.5 * bend) + wrong**2
    )  # inverse square of the deviation of the place of an edge
    weight = np.where(usable & (best == inner), weight, 0.0)
    weight = np.where((contrast > 4.0 * noise) | (behind is not None), weight, 0.0)
    radius = np.linalg.norm(outline.edge - outline.edge.mean(axis=1, keepdims=True), axis=-1).mean(axis=1)
    between = 2.0 * np.pi * radius / place.shape[1]
    floor = SHADED * np.maximum(1.0, LARGE / radius) if rises else np.full(radius.size, FLOOR)
    located = _fit_shifts(outline.outwards, place, weight, contrast, usable, floor, np.maximum(1.0, SHARED / between))
    if not rises:
        return located
    by_noise = _median(gap * noise * np.sqrt(2.0 / bend), usable) / NORMAL
    odd = np.sqrt(np.maximum(located.misfit**2 - by_noise**2, 0.0))
    wide = np.where(odd < UNLIKE, GROWTH * np.maximum(odd - ALIKE, 0.0), ANYWHERE * radius)
    return located._replace(covariance=located.covariance + wide[:, None, None] ** 2 * np.eye(2))


def _fit_shifts(
    outwards: Floats,
    place: Floats,
    weight: Floats,
    contrast: Floats,
    usable: NDArray[np.bool_],
    floor: Floats,
    shared: Floats,
) -> OutlineShifts:
    """Two shifts and a growth of each outline from its rays, with less weight for those that do not agree.

    ``floor`` (pixels) is added to the deviation of each, ``shared`` is the number of rays that see the same noise.
    """
    things = place.shape[0]
    rows = np.concatenate([outwards, np.ones((*place.shape, 1))], axis=-1)
    own, spread = weight.copy(), np.full(things, 1.0)
    answer = np.zeros((things, 3))
    ease = np.diag([1e-4, 1e-4, 100.0])  # the size is known to a part of a pixel
    for turn in range(6):
        normal = _normal(own, rows) + ease
        answer = np.linalg.solve(normal, np.einsum("tp,tp,tpi->ti", own, place, rows)[..., None])[..., 0]
        away = place - np.einsum("tpi,ti->tp", rows, answer)
        spread = np.maximum(NORMAL * _median(np.abs(away), weight > 0.0), 0.05)
        far = np.minimum(np.abs(away) / ((TUKEY if turn else 2.0 * TUKEY) * spread[:, None]), 1.0)
        own = weight * (1.0 - far**2) ** 2
    freedom = np.maximum((own > 0.0).sum(axis=-1) - 3, 1)
    worse = np.maximum((own * away**2).sum(axis=-1) / freedom, 1.0)
    normal = _normal(own, rows) + ease
    covariance = (np.linalg.inv(normal) * (shared * worse)[:, None, None])[:, :2, :2]
    covariance = covariance + floor[:, None, None] ** 2 * np.eye(2)
    counts = np.maximum(usable.sum(axis=-1), 1)
    agree = ((np.abs(away) < 0.7) & (weight > 0.0)).sum(axis=-1) / counts
    level = (contrast * usable).sum(axis=-1) / counts
    misfit = _median(np.where(weight > 0.0, np.abs(away + answer[:, 2:]), SHIFTS[-1]), usable)
    return OutlineShifts(answer[:, :2], covariance, agree, level, misfit)


def _faintness(contrast: Floats, usable: NDArray[np.bool_]) -> Floats:
    """By how much edges on the side of a ball that is in shadow are less sure than those in the light, (things, points).

    In shadow the brightness rises later behind an edge than the profile has it, which shifts a faint edge more than a clear one.
    """
    clear = np.quantile(np.where(usable, contrast, 0.0), 0.9, axis=-1, keepdims=True)
    return np.asarray(np.clip(clear / np.maximum(contrast, 1e-9), 1.0, FAINT), np.float64)


def _normal(weight: Floats, rows: Floats) -> Floats:
    """Normal matrix of each thing, (things, 3, 3)."""
    return np.asarray(np.swapaxes(rows * weight[..., None], -1, -2) @ rows, np.float64)


def _median(values: Floats, counts: NDArray[np.bool_]) -> Floats:
    """Median of those values of each row that count; 1 where none does."""
    ascending = np.sort(np.where(counts, values, np.inf), axis=-1)
    number = counts.sum(axis=-1)
    last = values.shape[-1] - 1
    places = (np.maximum(number - 1, 0) // 2, np.minimum(number // 2, last))
    low, high = (np.take_along_axis(ascending, at[:, None], axis=-1)[:, 0] for at in places)
    return np.where(number > 0, 0.5 * (low + high), 1.0)


# Where the camera stood and how its lens draws, from marks of known place in a picture.


USUAL, SPREAD = (
    1.6,
    0.7,
)  # focal lengths of cameras over the width of the picture, and the standard deviation of their logarithm
BENT = 0.3  # standard deviation of distortion before anything is known
FLOOR_OF_MARKS = 0.03  # pixels: marks are not found better than this


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
            ahead, behind = (self.moved(s).places(pixels, height) @ [1.0, 1j] for s in (step, -step))
            slope[i] = np.angle((ahead - center) / (behind - center)) / (2.0 * step[i])
        return np.asarray(np.sqrt(np.maximum(np.einsum("ik,ij,jk->k", slope, self.covariance, slope), 0.0)))


def calibrate(
    places: Complexes,
    pixels: ArrayLike,
    size: tuple[int, int],
    *,
    focal_length: float | None = None,
    distortion: int | Sequence[float] = 0,
    deviation: float = FLOOR_OF_MARKS,
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
        view.turn @ Rotation.from_rotvec(change[:3]).as_matrix(),
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
    return np.asarray(h / np.linalg.norm(h) * np.sign((x @ h[2, :2] + h[2, 2]).sum()))


def mapped(h: Floats, points: Floats) -> Floats:
    """Where a projective map takes points (..., 2)."""
    moved = points @ h[:, :2].T + h[:, 2]
    return np.asarray(moved[..., :2] / moved[..., 2:])


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
        camera = fitted(pixels, FLOOR_OF_MARKS)
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

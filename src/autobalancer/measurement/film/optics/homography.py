"""The projective map of a plane onto a picture, from marks: Hartley and Zisserman (2004), section 4.1, normalized."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from autobalancer.errors import QuestionError

Floats = NDArray[np.float64]
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
    p, q = _apply(a, x), _apply(b, u)
    one, zero = np.ones(len(p)), np.zeros((len(p), 3))
    row = np.column_stack([p, one])
    system = np.vstack([np.hstack([row, zero, -q[:, :1] * row]), np.hstack([zero, row, -q[:, 1:] * row])])
    h = np.linalg.svd(system)[2][-1].reshape(3, 3)
    h = np.linalg.solve(b, h @ a)
    return np.asarray(h / np.linalg.norm(h) * np.sign(_apply_weight(h, x)))


def mapped(h: Floats, places: ArrayLike) -> Floats:
    """Where a projective map takes places (..., 2)."""
    return _apply(h, np.asarray(places, np.float64))


def _apply(h: Floats, points: Floats) -> Floats:
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

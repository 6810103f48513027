"""Force of a nonlinear bearing towards its middle: a cubic spring, a stop behind a clearance, a measured characteristic.

    F(r) = k r^3 + K max(r - g, 0) + T(r)

T goes through the points of the table as a monotone cubic (Fritsch and Carlson 1980), and straight on with its last slope beyond
them.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class CentralForce:
    """The force in numbers, SI; ``points`` are distance (from 0, ascending) and force of the table."""

    cubic: float = 0.0
    contact: float = 0.0
    clearance: float = 0.0
    points: tuple[tuple[float, float], ...] = ()
    pieces: Floats = field(
        init=False, repr=False, compare=False
    )  # (n, 5) of T: distance where it begins, c3, c2, c1, c0

    def __post_init__(self) -> None:
        object.__setattr__(self, "pieces", _pieces(np.array(self.points, float).reshape(-1, 2)))

    def force(self, r: ArrayLike) -> Floats:
        """F at distances, N."""
        r = np.asarray(r, float)
        s, (c3, c2, c1, c0) = self._piece(r)
        far = np.maximum(r - self.clearance, 0.0)
        return np.asarray(self.cubic * r**3 + self.contact * far + ((c3 * s + c2) * s + c1) * s + c0)

    def slope(self, r: ArrayLike) -> Floats:
        """dF/dr, N/m; at the clearance itself that before the stop, unless there is no clearance."""
        r = np.asarray(r, float)
        s, (c3, c2, c1, _) = self._piece(r)
        touching = (r > self.clearance) | (self.clearance == 0.0)
        return np.asarray(3.0 * self.cubic * r**2 + self.contact * touching + (3.0 * c3 * s + 2.0 * c2) * s + c1)

    def stiffness(self, x: float, y: float) -> Floats:
        """What small motions about a deflection feel, (2, 2): F' along it and F/r across it."""
        r = float(np.hypot(x, y))
        along = float(self.slope(r))
        across = float(self.force(r)) / r if r > 0.0 else along
        n = np.array([x, y]) / r if r > 0.0 else np.array([1.0, 0.0])
        return np.asarray(across * np.eye(2) + (along - across) * np.outer(n, n))

    @property
    def reach(self) -> float:
        """The last distance of the table; infinite without one."""
        return float(self.points[-1][0]) if self.points else np.inf

    def _piece(self, r: Floats) -> tuple[Floats, Floats]:
        if not len(self.pieces):
            return np.zeros_like(r), np.zeros((4, *r.shape))
        number = np.maximum(np.searchsorted(self.pieces[:, 0], r, side="right") - 1, 0)
        return np.asarray(r - self.pieces[number, 0]), np.moveaxis(self.pieces[number, 1:], -1, 0)


def _pieces(points: Floats) -> Floats:
    if not len(points):
        return np.zeros((0, 5))
    from scipy.interpolate import PchipInterpolator  # only where needed: it takes a tenth of a second to load

    if points[0, 0] > 0.0:
        points = np.vstack([[0.0, 0.0], points])
    curve = PchipInterpolator(points[:, 0], points[:, 1])
    last = [points[-1, 0], 0.0, 0.0, float(curve(points[-1, 0], 1)), points[-1, 1]]
    return np.vstack([np.column_stack([points[:-1, 0], curve.c.T]), last])

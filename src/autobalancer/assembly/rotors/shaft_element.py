r"""One Timoshenko beam element with two nodes, in one plane.

Its coordinates are the deflection w and the rotation psi of the section at both ends; without shear psi = dw/dz. The
shapes are the deflections under end loads, with the shear parameter Phi = 12 E I/(kappa G A L^2), as in Przemieniecki
(1968), section 5.6, and Friswell et al. (2010), section 5.4: cubic in w, quadratic in psi, with constant shear
w' - psi. All matrices are their integrals, which four Gauss points take exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from autobalancer.assembly.rotors.model import Floats, Matrix

POINTS, WEIGHTS = (np.array(part) for part in np.polynomial.legendre.leggauss(4))
POINTS, WEIGHTS = 0.5 * (1.0 + POINTS), 0.5 * WEIGHTS  # on (0, 1)


@dataclass(frozen=True)
class Element:
    """A cylindrical element, SI."""

    length: float
    bending: float  # E I, N m^2
    shearing: float  # kappa G A, N
    mass: float  # rho A, kg/m
    rotary: float  # rho I, kg m; the polar one is twice that

    @property
    def phi(self) -> float:
        """Shear parameter: compliance in shear over that in bending."""
        return 12.0 * self.bending / (self.shearing * self.length**2)

    def shapes(self, s: Floats) -> tuple[Matrix, Matrix]:
        """w and psi at s = z/length (p,) for unit (w, psi, w, psi) at the ends, each (p, 4)."""
        length, phi = self.length, self.phi
        s = np.asarray(s, np.float64)
        bow = 0.5 * phi * s * (1.0 - s)
        w = np.stack([
            1.0 + phi * (1.0 - s) - 3.0 * s**2 + 2.0 * s**3,
            length * (s - 2.0 * s**2 + s**3 + bow),
            phi * s + 3.0 * s**2 - 2.0 * s**3,
            length * (s**3 - s**2 - bow),
        ], axis=-1)  # fmt: skip
        turn = 6.0 * (s**2 - s) / length
        psi = np.stack([
            turn, 1.0 - 4.0 * s + 3.0 * s**2 + phi * (1.0 - s), -turn, 3.0 * s**2 - 2.0 * s + phi * s,
        ], axis=-1)  # fmt: skip
        return w / (1.0 + phi), psi / (1.0 + phi)

    def curvature(self, s: Floats) -> Matrix:
        """dpsi/dz, (p, 4)."""
        length, phi = self.length, self.phi
        s = np.asarray(s, np.float64)
        bend = (12.0 * s - 6.0) / length
        rows = np.stack([bend, 6.0 * s - 4.0 - phi, -bend, 6.0 * s - 2.0 + phi], axis=-1)
        return np.asarray(rows / (length * (1.0 + phi)))

    @property
    def shear(self) -> Floats:
        """w' - psi, constant along the element, (4,)."""
        both = np.array([-1.0 / self.length, -0.5, 1.0 / self.length, -0.5])
        return both * self.phi / (1.0 + self.phi)

    def inertia(self) -> Matrix:
        """Mass matrix with the inertia of the sections against turning, (4, 4)."""
        w, _ = self.shapes(POINTS)
        return self.length * self.mass * _product(w, WEIGHTS) + 0.5 * self.gyroscopic()

    def gyroscopic(self) -> Matrix:
        """Polar inertia of the sections over their rotations, (4, 4), symmetric: g of G = [[0, g], [-g, 0]]."""
        return 2.0 * self.length * self.rotary * _product(self._turning, WEIGHTS)

    def stiffness(self) -> Matrix:
        """Stiffness in bending and shear, (4, 4)."""
        bent = self.length * self.bending * _product(self.curvature(POINTS), WEIGHTS)
        return bent + self.length * self.shearing * np.outer(self.shear, self.shear)

    def tension(self, first: float, last: float) -> Matrix:
        """Geometric stiffness under a tension that goes linearly from ``first`` to ``last``, N, (4, 4)."""
        force = first + (last - first) * POINTS
        return self.length * _product(self._turning + self.shear, WEIGHTS * force)

    @cached_property
    def _turning(self) -> Matrix:
        """psi at the points of the quadrature."""
        return self.shapes(POINTS)[1]


def cowper(poisson: float, hollow: float) -> float:
    """Shear coefficient of a round section whose inner diameter is ``hollow`` of the outer one: Cowper (1966)."""
    both, square = (1.0 + hollow**2) ** 2, hollow**2
    return 6.0 * (1.0 + poisson) * both / ((7.0 + 6.0 * poisson) * both + (20.0 + 12.0 * poisson) * square)


def _product(rows: Matrix, weights: Floats) -> Matrix:
    found = rows.T @ (weights[:, None] * rows)
    return np.asarray(0.5 * (found + found.T))  # exactly symmetric

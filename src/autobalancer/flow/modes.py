"""Exact modes of a fluid that only diffuses between walls that turn with the rotor.

Without secondary flow g_t = nu D2 g - r^2 w', g = 0 on the walls, so g/r is a sum of

    phi_n(r) sin(k pi z/H),  phi_n(r) = J1(l_n r) Y1(l_n a) - Y1(l_n r) J1(l_n a),  phi_n(b) = 0,

with the decay rates nu (l_n^2 + (k pi/H)^2); only odd k are excited by walls that turn together.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq
from scipy.special import j0, j1, y0, y1

from autobalancer.flow.annulus import Annulus, Floats, Matrix


def radial_roots(inner: float, outer: float, count: int) -> Floats:
    """The first ``count`` l_n, 1/m; each lies close to n pi/(b - a)."""

    def cross(wave: float) -> float:
        return float(j1(wave * outer) * y1(wave * inner) - y1(wave * outer) * j1(wave * inner))

    step = math.pi / (outer - inner)
    found: list[float] = []
    low, start = 1e-6 * step, cross(1e-6 * step)
    while len(found) < count:
        high = low + 0.1 * step
        end = cross(high)
        if start * end < 0.0:
            found.append(float(brentq(cross, low, high, xtol=1e-13 * step, rtol=1e-15)))
        low, start = high, end
    return np.array(found)


def radial_modes(inner: float, waves: Floats, radius: Floats) -> Matrix:
    """phi_n(r); (radius, mode)."""
    x = np.outer(radius, waves)
    return np.asarray(j1(x) * y1(waves * inner) - y1(x) * j1(waves * inner), np.float64)


def radial_shares(inner: float, outer: float, waves: Floats) -> Floats:
    """A_n in r = sum A_n phi_n(r), by orthogonality with the weight r."""
    ends = np.array([inner, outer])
    x = np.outer(ends, waves)
    y_a, j_a = y1(waves * inner), j1(waves * inner)
    jn2, yn2 = 2.0 / x * j1(x) - j0(x), 2.0 / x * y1(x) - y0(x)
    moment = ends[:, None] ** 2 * (jn2 * y_a - yn2 * j_a) / waves  # integral of r^2 C1 is r^2 C2 / l
    slope = waves * ((j0(x) - j1(x) / x) * y_a - (y0(x) - y1(x) / x) * j_a)  # phi'
    square = 0.5 * ends[:, None] ** 2 * slope**2 / waves**2  # integral of r C1^2 where C1 = 0 at both ends
    return np.asarray((moment[1] - moment[0]) / (square[1] - square[0]), np.float64)


def mode_table(annulus: Annulus, radial: int, axial: int) -> tuple[Matrix, Matrix]:
    """Decay rates (1/s) and gains at the orbit of the modes; (radial, axial), the axial wave numbers k are 1, 3, 5, ...

    After an impulsive start at the speed w from rest the fluid at the orbit turns with w (1 - sum gain exp(-rate t)).
    """
    waves = radial_roots(annulus.inner, annulus.outer, radial)
    k = 2.0 * np.arange(axial) + 1.0
    shape = radial_modes(annulus.inner, waves, np.array([annulus.orbit_radius]))[0] / annulus.orbit_radius
    middle = 4.0 / (math.pi * k) * np.where(np.arange(axial) % 2 == 0, 1.0, -1.0)
    rates = annulus.viscosity * (waves[:, None] ** 2 + (math.pi * k[None, :] / annulus.height) ** 2)
    return rates, np.outer(radial_shares(annulus.inner, annulus.outer, waves) * shape, middle)

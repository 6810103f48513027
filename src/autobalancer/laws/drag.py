"""Drag of a ball in its race in the Stokes range."""

from __future__ import annotations

import math


def annulus_cd_re(width_ratio: float, radius_ratio: float) -> float:
    """c_d Re of a ball in the annulus of a balancer (Spannan 2021, 5.22), for Re <= 10.

    ``width_ratio`` is W_1 / r_b, ``radius_ratio`` is r_b / eps.
    """
    return float(248.0 * width_ratio ** (-11.0 / 8.0) + 245.0 + 813.0 * (radius_ratio - 0.08))


def linear_drag(cd_re: float, density: float, viscosity: float, ball_radius: float, orbit_radius: float) -> float:
    """beta = (c_d Re) (pi/4) rho nu r_b eps^2 in N m s (Spannan 2021, 5.26); SI in.

    It is F eps over phi' with F = 1/2 rho (pi r_b^2) c_d u^2, u = eps phi', Re = u (2 r_b) / nu.
    """
    return cd_re * math.pi / 4.0 * density * viscosity * ball_radius * orbit_radius**2

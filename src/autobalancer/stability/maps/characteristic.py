"""Exact stability of the balanced state of an isotropic planar rotor with equal balls, in closed form.

The full equations are linearized in the frame that turns with the rotor. With P(s) = I s^2 + beta s,
Z(s) = M s^2 + b s + k, c = (m eps)^2 and S2 = sum over balls of e^(2 i phi) the eigenvalues are the roots of

    P^2 Z+ Z- - (c N / 2) P [(s + i W)^4 Z- + (s - i W)^4 Z+] + (c^2 / 4) (N^2 - |S2|^2) (s^2 + W^2)^4 = 0,

Z+ = Z(s + i W), Z- = Z(s - i W), and, for N > 2 balls, of s^(N-2) (I s + beta)^(N-2).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class PlanarBalancer:
    """An isotropic planar rotor with N equal balls in one centric race; SI, mass includes the balls."""

    mass: float
    stiffness: float
    damping: float
    count: int
    moment: float  # m eps of one ball
    inertia: float  # of one ball angle
    drag: float  # beta of one ball

    @property
    def critical_speed(self) -> float:
        """sqrt(k/M), rad/s."""
        return float(np.sqrt(self.stiffness / self.mass))

    @property
    def sommerfeld_number(self) -> float:
        """S = (m eps w_c)^2 / (b beta); infinite without damping."""
        dissipation = self.damping * self.drag
        return float("inf") if dissipation == 0.0 else float((self.moment * self.critical_speed) ** 2 / dissipation)


def planar_eigenvalues(balancer: PlanarBalancer, speed: float, spread: float) -> NDArray[np.complex128]:
    """The eight eigenvalues that decide, 1/s, at a rotor speed (rad/s).

    ``spread`` is |S2|, between 0 (balls evenly spread over directions, such as two at 135 deg) and N (in line).
    """
    b = balancer
    w = b.critical_speed  # scaled by the critical speed, or the coefficients span forty decades
    ball = Polynomial([0.0, b.drag * w, b.inertia * w * w])
    up, down = Polynomial([1j * speed / w, 1.0]), Polynomial([-1j * speed / w, 1.0])
    rotor = [b.mass * w * w * x * x + b.damping * w * x + b.stiffness for x in (up, down)]
    c = b.moment**2 * w**4
    sides = up**4 * rotor[1] + down**4 * rotor[0]
    polynomial = ball**2 * rotor[0] * rotor[1] - 0.5 * c * b.count * ball * sides
    polynomial += 0.25 * c * c * (b.count**2 - spread**2) * (up * down) ** 4
    return np.asarray(w * np.roots(polynomial.coef.real[::-1]), np.complex128)


def growth_rates(balancer: PlanarBalancer, speeds: Floats, spreads: Floats | float) -> tuple[Floats, Floats]:
    """Growth rates (1/s) at many speeds, and the frequencies (rad/s, seen in the rotor) of what grows: compiled.

    The same as :func:`growth_rate`, which also steps in where two eigenvalues nearly coincide and the iteration fails.
    """
    return scaled_growth_rates(scaled_points(balancer, speeds, spreads), balancer.critical_speed)


def scaled_points(balancer: PlanarBalancer, speeds: Floats, spreads: Floats | float) -> Matrix:
    """Rows (speed, damping, drag, coupling, spread), all scaled as in :mod:`autobalancer.kernels.characteristic`."""
    b, critical = balancer, balancer.critical_speed
    points = np.empty((speeds.size, 5))
    points[:, 0] = speeds / critical
    points[:, 1] = b.damping / (b.mass * critical)
    points[:, 2] = b.drag / (b.inertia * critical)
    points[:, 3] = 0.5 * b.count * b.moment**2 / (b.inertia * b.mass)
    points[:, 4] = np.minimum(np.asarray(spreads) / b.count, 1.0)
    return points


def scaled_growth_rates(points: Matrix, critical: Floats | float) -> tuple[Floats, Floats]:
    """Growth rates and frequencies of scaled points, times the critical speed."""
    from autobalancer.kernels import characteristic as kernel  # loads compiled code: only when needed

    rates, frequencies = np.empty(len(points)), np.empty(len(points))
    kernel.growth_rates(points, rates, frequencies, np.zeros((8, 2)))
    for row in np.flatnonzero(np.isnan(rates)):
        speed, damping, drag, coupling, spread = (float(x) for x in points[row])
        unit = PlanarBalancer(1.0, 1.0, damping, 2, float(np.sqrt(coupling)), 1.0, drag)
        rates[row], frequencies[row] = _leading(unit, speed, 2.0 * spread)
    return rates * critical, frequencies * critical


def growth_rate(balancer: PlanarBalancer, speed: float, spread: float) -> float:
    """Greatest real part of the eigenvalues, 1/s; the balanced state is stable where it is negative.

    For balls in line (|S2| = N) one eigenvalue is zero by symmetry and does not count.
    """
    return _leading(balancer, speed, spread)[0]


def _leading(balancer: PlanarBalancer, speed: float, spread: float) -> tuple[float, float]:
    values = planar_eigenvalues(balancer, speed, spread)
    if balancer.count - spread < 1e-9 * balancer.count:
        values = np.delete(values, np.argmin(np.abs(values)))
    best = values[np.argmax(values.real)]
    return float(best.real), float(abs(best.imag))


def worst_case_border(balancer: PlanarBalancer) -> float:
    """Exact border speed for |S2| = 0, rad/s, from the explicit curve with the whirl frequency as parameter.

    It is the worst case over the unbalance for a well damped rotor; where the rotor is damped lightly, balls in line
    (|S2| = N) may have a higher border.

    With D = M (w^2 - w_c^2): beta(w)^2 = (c N I w^4 / 2) / (D (1 + D^2/(b w)^2)), W = w + beta D / (I b w). beta falls
    with w; below its limit for w to infinity the balanced state is never stable and the border is infinite.
    """
    from scipy.optimize import brentq

    b = balancer
    critical = b.critical_speed
    if b.damping == 0.0 or b.drag == 0.0:
        return float("inf")
    c = b.moment**2

    def beta(w: float) -> float:
        d = b.mass * (w * w - critical * critical)
        return float(np.sqrt(0.5 * c * b.count * b.inertia * w**4 / (d * (1.0 + (d / (b.damping * w)) ** 2))))

    def miss(x: float) -> float:  # x = ln(w/w_c - 1)
        return float(np.log(beta(critical * (1.0 + np.exp(x))) / b.drag))

    low, high = -34.0, 30.0
    if miss(high) > 0.0:
        return float("inf")
    if miss(low) < 0.0:
        return critical
    w = critical * (1.0 + np.exp(brentq(miss, low, high, xtol=1e-13)))
    return float(w + b.drag * b.mass * (w * w - critical * critical) / (b.inertia * b.damping * w))

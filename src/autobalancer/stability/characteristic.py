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
from scipy.optimize import brentq


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


def growth_rate(balancer: PlanarBalancer, speed: float, spread: float) -> float:
    """Greatest real part of the eigenvalues, 1/s; the balanced state is stable where it is negative.

    For balls in line (|S2| = N) one eigenvalue is zero by symmetry and does not count.
    """
    values = planar_eigenvalues(balancer, speed, spread)
    if balancer.count - spread < 1e-9 * balancer.count:
        values = np.delete(values, np.argmin(np.abs(values)))
    return float(values.real.max())


def worst_case_border(balancer: PlanarBalancer) -> float:
    """Exact border speed for |S2| = 0, rad/s, from the explicit curve with the whirl frequency as parameter.

    With D = M (w^2 - w_c^2): beta(w)^2 = (c N I w^4 / 2) / (D (1 + D^2/(b w)^2)), W = w + beta D / (I b w). beta falls
    with w; below its limit for w to infinity the balanced state is never stable and the border is infinite.
    """
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


def exact_border(balancer: PlanarBalancer, spread: float, highest: float) -> float:
    """Lowest speed from which on the balanced state is stable up to ``highest`` (rad/s); infinite if not there."""
    speeds = balancer.critical_speed + np.geomspace(
        1e-6 * balancer.critical_speed, highest - balancer.critical_speed, 600
    )
    rates = np.array([growth_rate(balancer, speed, spread) for speed in speeds])
    unstable = np.flatnonzero(rates >= 0.0)
    if unstable.size == 0:
        return balancer.critical_speed
    last = unstable[-1]
    if last == speeds.size - 1:
        return float("inf")
    return float(brentq(lambda w: growth_rate(balancer, w, spread), speeds[last], speeds[last + 1], xtol=1e-10))
